// A pack of numbers that are worked together: the scalar of the kernels and, through templates, of the constitutive laws.
//
// Included by the kernel files only. Each is compiled for one instruction set with its own MPM_SIMD_BYTES, and everything here has
// internal linkage, so that code for a new processor can never be linked into a function that an old one runs.
#pragma once

#include <cstdint>
#include <type_traits>
#include <utility>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "core/types.hpp"

#ifndef MPM_SIMD_BYTES
#define MPM_SIMD_BYTES 16
#endif
#define MPM_INLINE inline __attribute__((always_inline))

namespace matpoint {
namespace {

template <class R>
struct Mask {
  using Integer = std::conditional_t<sizeof(R) == 8, std::int64_t, std::int32_t>;
  typedef Integer Native __attribute__((vector_size(MPM_SIMD_BYTES)));
  /// For arithmetic on the bits of numbers: the bits of a nan may overflow, which only unsigned integers are allowed to do.
  typedef std::make_unsigned_t<Integer> Bits __attribute__((vector_size(MPM_SIMD_BYTES)));
  Native v;

  MPM_INLINE friend Mask operator&(Mask a, Mask b) { return {a.v & b.v}; }
  MPM_INLINE friend Mask operator|(Mask a, Mask b) { return {a.v | b.v}; }
  MPM_INLINE Mask operator~() const { return {~v}; }
};

template <class R>
struct Pack {
  static constexpr int k_width = MPM_SIMD_BYTES / sizeof(R);
  typedef R Native __attribute__((vector_size(MPM_SIMD_BYTES)));
  Native v;

  Pack() = default;
  MPM_INLINE Pack(Native native) : v(native) {}
  MPM_INLINE Pack(double x) : v(Native{} + static_cast<R>(x)) {}

  // Through typed pointers and not memcpy: a copy of bytes could be a copy of anything, and everything would be read again after it.
  typedef R Unaligned __attribute__((vector_size(MPM_SIMD_BYTES), aligned(sizeof(R))));
  MPM_INLINE static Pack load(const R* from) { return *reinterpret_cast<const Native*>(from); }
  MPM_INLINE static Pack load_unaligned(const R* from) { return *reinterpret_cast<const Unaligned*>(from); }
  MPM_INLINE void store(R* to) const { *reinterpret_cast<Native*>(to) = v; }

  MPM_INLINE friend Pack operator+(Pack a, Pack b) { return a.v + b.v; }
  MPM_INLINE friend Pack operator-(Pack a, Pack b) { return a.v - b.v; }
  MPM_INLINE friend Pack operator*(Pack a, Pack b) { return a.v * b.v; }
  MPM_INLINE friend Pack operator/(Pack a, Pack b) { return a.v / b.v; }
  MPM_INLINE Pack operator-() const { return -v; }
  MPM_INLINE Pack& operator+=(Pack b) {
    v += b.v;
    return *this;
  }
  MPM_INLINE Pack& operator-=(Pack b) {
    v -= b.v;
    return *this;
  }
  MPM_INLINE Pack& operator*=(Pack b) {
    v *= b.v;
    return *this;
  }

  MPM_INLINE friend Mask<R> operator<(Pack a, Pack b) { return {a.v < b.v}; }
  MPM_INLINE friend Mask<R> operator>(Pack a, Pack b) { return {a.v > b.v}; }
  MPM_INLINE friend Mask<R> operator<=(Pack a, Pack b) { return {a.v <= b.v}; }
  MPM_INLINE friend Mask<R> operator>=(Pack a, Pack b) { return {a.v >= b.v}; }
};

template <class R>
MPM_INLINE Pack<R> select(Mask<R> mask, Pack<R> a, Pack<R> b) {
  return mask.v ? a.v : b.v;
}
template <class R>
MPM_INLINE Pack<R> min(Pack<R> a, Pack<R> b) {
  return a.v < b.v ? a.v : b.v;
}
template <class R>
MPM_INLINE Pack<R> max(Pack<R> a, Pack<R> b) {
  return a.v > b.v ? a.v : b.v;
}
template <class R>
MPM_INLINE Pack<R> abs(Pack<R> a) {
  using Bits = typename Mask<R>::Bits;
  return (typename Pack<R>::Native)(((Bits)(a.v) << 1) >> 1);
}
template <class R>
MPM_INLINE Pack<R> sqrt(Pack<R> a) {
  for (int i = 0; i < Pack<R>::k_width; ++i) a.v[i] = sizeof(R) == 8 ? __builtin_sqrt(a.v[i]) : __builtin_sqrtf(a.v[i]);
  return a;
}

/// Whether any lane is set.
template <class R>
MPM_INLINE bool any(Mask<R> mask) {
#if MPM_SIMD_BYTES == 64 && defined(__AVX512BW__)
  return _mm512_test_epi64_mask((__m512i)mask.v, (__m512i)mask.v) != 0;
#elif MPM_SIMD_BYTES == 32 && defined(__AVX2__)
  return _mm256_testz_si256((__m256i)mask.v, (__m256i)mask.v) == 0;
#else
  typedef std::int64_t Words __attribute__((vector_size(MPM_SIMD_BYTES)));
  const Words words = (Words)mask.v;
  std::int64_t all = 0;
  for (int i = 0; i < MPM_SIMD_BYTES / 8; ++i) all |= words[i];
  return all != 0;
#endif
}

/// Whether `b` is set in all lanes in which `a` is.
template <class R>
MPM_INLINE bool all_of(Mask<R> a, Mask<R> b) {
#if MPM_SIMD_BYTES == 32 && defined(__AVX2__)
  return _mm256_testc_si256((__m256i)b.v, (__m256i)a.v) != 0;
#else
  return !any(a & ~b);
#endif
}

/// How many of `slot_count` slots hold a particle in any lane of a pack of cells, given the cells' counts.
template <class R>
MPM_INLINE int slots_in_use(Pack<R> counts, int slot_count) {
  R most = 0;
  for (int i = 0; i < Pack<R>::k_width; ++i) most = counts.v[i] > most ? counts.v[i] : most;
  return static_cast<int>(most) < slot_count ? static_cast<int>(most) : slot_count;
}

/// Lanes n, n + 1, ... of `low`, then the first n of `high`.
template <int n, class R, int... I>
MPM_INLINE Pack<R> shift_down(Pack<R> low, Pack<R> high, std::integer_sequence<int, I...>) {
  return __builtin_shufflevector(low.v, high.v, (I + n)...);
}
template <int n = 1, class R>
MPM_INLINE Pack<R> shift_down(Pack<R> low, Pack<R> high) {
  return shift_down<n>(low, high, std::make_integer_sequence<int, Pack<R>::k_width>{});
}
/// The last n lanes of `low`, then lanes 0, 1, ... of `high`.
template <int n, class R, int... I>
MPM_INLINE Pack<R> shift_up(Pack<R> low, Pack<R> high, std::integer_sequence<int, I...>) {
  return __builtin_shufflevector(low.v, high.v, (I + Pack<R>::k_width - n)...);
}
template <int n = 1, class R>
MPM_INLINE Pack<R> shift_up(Pack<R> low, Pack<R> high) {
  return shift_up<n>(low, high, std::make_integer_sequence<int, Pack<R>::k_width>{});
}

/// Whole numbers as reals: exact for |i| < 2^51 (2^22 in single precision). Adding the magic number puts i into the mantissa.
MPM_INLINE Pack<double> to_real(Mask<double>::Bits i) {
  const auto bits = i + 0x4338000000000000ull;
  return (Pack<double>::Native)(bits)-0x1.8p52;
}
MPM_INLINE Pack<float> to_real(Mask<float>::Bits i) {
  const auto bits = i + 0x4b400000u;
  return (Pack<float>::Native)(bits)-0x1.8p23f;
}

/// ln x for normal x > 0, within 2 units in the last place: x = 2^k m with m in [sqrt(1/2), sqrt(2)), ln m = 2 artanh((m - 1)/(m + 1)).
MPM_INLINE Pack<double> log(Pack<double> x) {
  using P = Pack<double>;
  const auto bits = (Mask<double>::Bits)(x.v);
  // Shifted without sign and with a bias: an arithmetic shift of 64-bit integers is slow below AVX-512.
  const auto biased = bits - 0x3fe6a09e667f3bcdull + 0x4000000000000000ull;
  const auto k = (biased >> 52) - 1024;
  const auto m_bits = bits - (k << 52);
  const P m = (P::Native)(m_bits);
  const P f = m - P(1);
  const P s = f / (m + P(1));
  const P z = s * s;
  const P z2 = z * z;
  const P z4 = z2 * z2;
  const P low = (P(2.0 / 5) + z * P(2.0 / 7)) * z + P(2.0 / 3);
  const P middle = P(2.0 / 9) + z * P(2.0 / 11) + z2 * (P(2.0 / 13) + z * P(2.0 / 15));
  const P high = P(2.0 / 17) + z * P(2.0 / 19);
  const P tail = z * (low + z2 * z * (middle + z4 * high));
  // ln m = s (2 + tail) = f - s (f - tail): f is exact and large, so rounding of the rest hardly counts.
  const P log_m = f - s * (f - tail);
  const P kr = to_real(k);
  return kr * P(0x1.62e42fefa38p-1) + (log_m + kr * P(0x1.ef35793c7673p-45));
}
MPM_INLINE Pack<float> log(Pack<float> x) {
  using P = Pack<float>;
  const auto bits = (Mask<float>::Bits)(x.v);
  const auto k = (Mask<float>::Bits)((Mask<float>::Native)(bits - 0x3f3504f3u) >> 23);
  const auto m_bits = bits - (k << 23);
  const P m = (P::Native)(m_bits);
  const P f = m - P(1);
  const P s = f / (m + P(1));
  const P z = s * s;
  const P tail = z * (P(2.0 / 3) + z * (P(2.0 / 5) + z * (P(2.0 / 7) + z * P(2.0 / 9))));
  const P log_m = f - s * (f - tail);
  return to_real(k) * P(0.693147180559945) + log_m;
}

/// e^x, within a few units in the last place for |x| < 700 (80 in single precision).
MPM_INLINE Pack<double> exp(Pack<double> x) {
  using P = Pack<double>;
  const P magic = P(0x1.8p52);
  const P shifted = x * P(1.4426950408889634) + magic;
  const P k = shifted - magic;
  const P r = (x - k * P(0x1.62e42fefa38p-1)) - k * P(0x1.ef35793c7673p-45);
  P sum = P(1.0 / 6227020800);
  const double factorials[] = {479001600, 39916800, 3628800, 362880, 40320, 5040, 720, 120, 24, 6, 2, 1, 1};
  for (const double factorial : factorials) sum = sum * r + P(1 / factorial);
  const auto bits = (Mask<double>::Bits)(sum.v) + ((Mask<double>::Bits)(shifted.v) << 52);
  return (P::Native)(bits);
}
MPM_INLINE Pack<float> exp(Pack<float> x) {
  using P = Pack<float>;
  const P magic = P(0x1.8p23);
  const P shifted = x * P(1.4426950408889634) + magic;
  const P k = shifted - magic;
  const P r = (x - k * P(0.693359375)) - k * P(-2.12194440e-4);
  P sum = P(1.0 / 5040);
  const double factorials[] = {720, 120, 24, 6, 2, 1, 1};
  for (const double factorial : factorials) sum = sum * r + P(1 / factorial);
  const auto bits = (Mask<float>::Bits)(sum.v) + ((Mask<float>::Bits)(shifted.v) << 23);
  return (P::Native)(bits);
}

}  // namespace
}  // namespace matpoint
