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

#include "core/scalar.hpp"

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
#if MPM_SIMD_BYTES == 64 && defined(__AVX512F__)
  // Masked: GCC 12 warns of the plain one, whose unused operand it does not initialise.
  if constexpr (sizeof(R) == 8) return (typename Pack<R>::Native)_mm512_maskz_sqrt_pd(0xff, (__m512d)a.v);
  if constexpr (sizeof(R) == 4) return (typename Pack<R>::Native)_mm512_maskz_sqrt_ps(0xffff, (__m512)a.v);
#elif MPM_SIMD_BYTES == 32 && defined(__AVX2__)
  if constexpr (sizeof(R) == 8) return (typename Pack<R>::Native)_mm256_sqrt_pd((__m256d)a.v);
  if constexpr (sizeof(R) == 4) return (typename Pack<R>::Native)_mm256_sqrt_ps((__m256)a.v);
#else
  for (int i = 0; i < Pack<R>::k_width; ++i)
    a.v[i] = static_cast<R>(sizeof(R) == 8 ? __builtin_sqrt(a.v[i]) : __builtin_sqrtf(static_cast<float>(a.v[i])));
  return a;
#endif
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

/// ln(1 + f) for f in [sqrt(1/2) - 1, sqrt(2) - 1], by 2 artanh(f/(2 + f)).
MPM_INLINE Pack<double> log1p_near_0(Pack<double> f) {
  using P = Pack<double>;
  const P s = f / (P(2) + f);
  const P z = s * s;
  const P z2 = z * z;
  const P z4 = z2 * z2;
  const P low = (P(2.0 / 5) + z * P(2.0 / 7)) * z + P(2.0 / 3);
  const P middle = P(2.0 / 9) + z * P(2.0 / 11) + z2 * (P(2.0 / 13) + z * P(2.0 / 15));
  const P high = P(2.0 / 17) + z * P(2.0 / 19);
  const P tail = z * (low + z2 * z * (middle + z4 * high));
  // s (2 + tail) = f - s (f - tail): f is exact and large, so rounding of the rest hardly counts.
  return f - s * (f - tail);
}
MPM_INLINE Pack<float> log1p_near_0(Pack<float> f) {
  using P = Pack<float>;
  const P s = f / (P(2) + f);
  const P z = s * s;
  const P tail = z * (P(2.0 / 3) + z * (P(2.0 / 5) + z * (P(2.0 / 7) + z * P(2.0 / 9))));
  return f - s * (f - tail);
}

/// x = 2^k (1 + f) with 1 + f in [sqrt(1/2), sqrt(2)), for normal x > 0.
template <class R>
struct Scaled {
  Pack<R> k;
  Pack<R> f;
};
MPM_INLINE Scaled<double> split(Pack<double> x) {
  using P = Pack<double>;
  const auto bits = (Mask<double>::Bits)(x.v);
  // Shifted without sign and with a bias: an arithmetic shift of 64-bit integers is slow below AVX-512.
  const auto biased = bits - 0x3fe6a09e667f3bcdull + 0x4000000000000000ull;
  const auto k = (biased >> 52) - 1024;
  const auto m_bits = bits - (k << 52);
  const P m = (P::Native)(m_bits);
  return {to_real(k), m - P(1)};
}
MPM_INLINE Scaled<float> split(Pack<float> x) {
  using P = Pack<float>;
  const auto bits = (Mask<float>::Bits)(x.v);
  const auto k = (Mask<float>::Bits)((Mask<float>::Native)(bits - 0x3f3504f3u) >> 23);
  const auto m_bits = bits - (k << 23);
  const P m = (P::Native)(m_bits);
  return {to_real(k), m - P(1)};
}
MPM_INLINE Pack<double> add_logarithm_of_2(Pack<double> k, Pack<double> log_m) {
  return k * Pack<double>(0x1.62e42fefa38p-1) + (log_m + k * Pack<double>(0x1.ef35793c7673p-45));
}
MPM_INLINE Pack<float> add_logarithm_of_2(Pack<float> k, Pack<float> log_m) { return k * Pack<float>(0.693147180559945) + log_m; }

/// ln x for normal x > 0, within 2 units in the last place.
template <class R>
MPM_INLINE Pack<R> log(Pack<R> x) {
  const Scaled<R> scaled = split(x);
  return add_logarithm_of_2(scaled.k, log1p_near_0(scaled.f));
}
/// ln(1 + h) for h > -1, with the digits of h where it is small.
template <class R>
MPM_INLINE Pack<R> log1p(Pack<R> h) {
  using P = Pack<R>;
  const Scaled<R> scaled = split(P(1) + h);
  const Mask<R> is_near_0 = (scaled.k <= P(0)) & (scaled.k >= P(0));
  return add_logarithm_of_2(scaled.k, log1p_near_0(select(is_near_0, h, scaled.f)));
}

/// e^x = 2^k (1 + r s): k in the low bits of `shifted`, |r| <= ln(2)/2, s the series of (e^r - 1)/r.
template <class R>
struct Exponent {
  Pack<R> shifted;
  Pack<R> r;
  Pack<R> s;
};
MPM_INLINE Exponent<double> exponent_of(Pack<double> x) {
  using P = Pack<double>;
  const P magic = P(0x1.8p52);
  const P shifted = x * P(1.4426950408889634) + magic;
  const P k = shifted - magic;
  const P r = (x - k * P(0x1.62e42fefa38p-1)) - k * P(0x1.ef35793c7673p-45);
  P sum = P(1.0 / 6227020800);
  const double factorials[] = {479001600, 39916800, 3628800, 362880, 40320, 5040, 720, 120, 24, 6, 2, 1};
  for (const double factorial : factorials) sum = sum * r + P(1 / factorial);
  return {shifted, r, sum};
}
MPM_INLINE Exponent<float> exponent_of(Pack<float> x) {
  using P = Pack<float>;
  const P magic = P(0x1.8p23);
  const P shifted = x * P(1.4426950408889634) + magic;
  const P k = shifted - magic;
  const P r = (x - k * P(0.693359375)) - k * P(-2.12194440e-4);
  P sum = P(1.0 / 5040);
  const double factorials[] = {720, 120, 24, 6, 2, 1};
  for (const double factorial : factorials) sum = sum * r + P(1 / factorial);
  return {shifted, r, sum};
}
/// x 2^k, with k in the low bits of `shifted`.
template <class R>
MPM_INLINE Pack<R> times_power_of_2(Pack<R> x, Pack<R> shifted) {
  using Bits = typename Mask<R>::Bits;
  const auto bits = (Bits)(x.v) + ((Bits)(shifted.v) << (sizeof(R) == 8 ? 52 : 23));
  return (typename Pack<R>::Native)(bits);
}

/// e^x, within a few units in the last place for |x| < 700 (80 in single precision).
template <class R>
MPM_INLINE Pack<R> exp(Pack<R> x) {
  const Exponent<R> e = exponent_of(x);
  return times_power_of_2(e.s * e.r + Pack<R>(1), e.shifted);
}
/// e^x - 1, with the digits of x where it is small.
template <class R>
MPM_INLINE Pack<R> expm1(Pack<R> x) {
  using P = Pack<R>;
  const Exponent<R> e = exponent_of(x);
  const P power = times_power_of_2(P(1), e.shifted);
  return power * (e.s * e.r) + (power - P(1));
}

}  // namespace

template <>
inline constexpr Real k_unit_roundoff<Pack<float>> = 6e-8;

}  // namespace matpoint
