// Functions of a symmetric tensor by its principal values: written once, for numbers, for packs of them, and for numbers with derivatives.
//
// Elastic states are kept as h = b - I, b the elastic left Cauchy-Green tensor: where strains are small, b has lost the digits that h has.
#pragma once

#include <array>
#include <type_traits>

#include "core/dual.hpp"
#include "core/tensor.hpp"

namespace matpoint {

/// Whether a scalar carries derivatives of its own (automatic differentiation), so that no eigenvector may be differentiated with it.
template <class T>
constexpr bool k_has_derivatives = requires(const T& x) {
  x.value();
  x.derivatives();
};

/// Principal values h_i of a symmetric tensor h, half the logarithms e_i = ln(1 + h_i)/2, and the way back.
template <class T, bool is_plane>
class Spectrum;

/// Plane: in closed form. The third direction is z.
template <class T>
class Spectrum<T, true> {
 public:
  explicit Spectrum(const Mat3<T, true>& h) {
    const T mean = T(0.5 * (h(0, 0) + h(1, 1)));
    const T d = T(0.5 * (h(0, 0) - h(1, 1)));
    const T R = T(sqrt(T(d * d + h(0, 1) * h(0, 1))));
    value[0] = mean + R;
    // mean - R would cancel where one stretch is far below the other: det b is what keeps the digits.
    const T det_minus_1 = h(0, 0) + h(1, 1) + (h(0, 0) * h(1, 1) - h(0, 1) * h(0, 1));
    value[1] = (det_minus_1 - value[0]) / (T(1.0) + value[0]);
    value[2] = h(2, 2);
    const auto is_round = R <= T(0.0);
    const T inverse = T(1.0) / select(is_round, T(1.0), R);
    cos_2a_ = select(is_round, T(1.0), T(d * inverse));
    sin_2a_ = select(is_round, T(0.0), T(h(0, 1) * inverse));
    for (int i = 0; i < 3; ++i) half_log[i] = 0.5 * log1p(value[i]);
  }
  /// The tensor with these principal values.
  Mat3<T, true> compose(const T* values) const {
    Mat3<T, true> result;
    const T mean = T(0.5 * (values[0] + values[1]));
    const T d = T(0.5 * (values[0] - values[1]));
    result(0, 0) = mean + d * cos_2a_;
    result(1, 1) = mean - d * cos_2a_;
    result(0, 1) = d * sin_2a_;
    result(1, 0) = result(0, 1);
    result(2, 2) = values[2];
    return result;
  }
  /// Principal directions, in columns.
  Mat3<T, true> directions() const {
    const Real a = 0.5 * std::atan2(sin_2a_, cos_2a_);
    return {{std::cos(a), -std::sin(a), std::sin(a), std::cos(a), 1}};
  }

  T value[3];
  T half_log[3];

 private:
  T cos_2a_, sin_2a_;
};

/// Full: cyclic Jacobi. After four sweeps of three rotations nothing is left off the diagonal, whatever the matrix, so that no lane waits
/// for another one. Source: Golub & Van Loan, Matrix Computations, sec. 8.5.
template <class T>
class Spectrum<T, false> {
 public:
  explicit Spectrum(const Mat3<T>& h) {
    T a[3] = {h(0, 0), h(1, 1), h(2, 2)};
    T off[3] = {h(1, 2), h(0, 2), h(0, 1)};  // by the index that is missing
    Q_ = Mat3<T>::identity();
    constexpr int k_sweeps = 4;
    for (int sweep = 0; sweep < k_sweeps; ++sweep) {
      rotate<0, 1>(a, off);
      rotate<0, 2>(a, off);
      rotate<1, 2>(a, off);
    }
    for (int i = 0; i < 3; ++i) {
      value[i] = a[i];
      half_log[i] = 0.5 * log1p(a[i]);
    }
  }
  Mat3<T> compose(const T* values) const {
    Mat3<T> result;
    for (int r = 0; r < 3; ++r) {
      for (int c = r; c < 3; ++c) {
        result(r, c) = Q_(r, 0) * values[0] * Q_(c, 0) + Q_(r, 1) * values[1] * Q_(c, 1) + Q_(r, 2) * values[2] * Q_(c, 2);
        result(c, r) = result(r, c);
      }
    }
    return result;
  }
  Mat3<T> directions() const { return Q_; }

  T value[3];
  T half_log[3];

 private:
  template <int p, int q>
  void rotate(T (&a)[3], T (&off)[3]) {
    constexpr int r = 3 - p - q;
    const T b = off[r];
    const T d = a[q] - a[p];
    const T root = T(sqrt(T(d * d + 4.0 * (b * b))));
    const T size = abs(d) + root + T(1e-30);
    const T t = select(d < T(0.0), T(-2.0 * b), T(2.0 * b)) / size;
    const T c = T(1.0) / T(sqrt(T(T(1.0) + t * t)));
    const T s = t * c;
    a[p] = a[p] - t * b;
    a[q] = a[q] + t * b;
    off[r] = T(0.0);
    const T ap = off[q];  // a_pr
    const T aq = off[p];  // a_qr
    off[q] = c * ap - s * aq;
    off[p] = s * ap + c * aq;
    for (int i = 0; i < 3; ++i) {
      const T x = Q_(i, p);
      const T y = Q_(i, q);
      Q_(i, p) = c * x - s * y;
      Q_(i, q) = s * x + c * y;
    }
  }

  Mat3<T> Q_;
};

/// The tensor whose principal values are `map` of the half logarithms of I + h, e.g. the stress of an isotropic solid. `map` takes a
/// pointer to three numbers and gives an array of three; it is called with T, or, where T has derivatives, with Dual<3>. Where a law
/// depends on a number beside h, too, `map` takes that as well, and is called with Dual<4>.
///
/// Derivatives are taken of the map only and turned into the tensor's in the principal basis: eigenvectors have none where stretches are
/// equal. Source: Ogden, Non-Linear Elastic Deformations (1984), sec. 6.1.4.
template <class T, bool is_plane, class Map, class... Beside>
Mat3<T, is_plane> isotropic(const Mat3<T, is_plane>& h, Map&& map, const Beside&... beside) {
  using M = Mat3<T, is_plane>;
  static_assert(sizeof...(Beside) <= 1);
  if constexpr (!k_has_derivatives<T>) {
    const Spectrum<T, is_plane> spectrum(h);
    const std::array<T, 3> values = map(spectrum.half_log, beside...);
    return spectrum.compose(values.data());
  } else {
    constexpr int k_count = 3 + sizeof...(Beside);
    using V = Mat3<Real, is_plane>;
    constexpr Real k_equal = 1e-5;  // relative to a stretch
    V of_values;
    for (int k = 0; k < V::k_size; ++k) of_values.entries[k] = h.entries[k].value();
    const Spectrum<Real, is_plane> spectrum(of_values);
    using D = Dual<k_count>;
    D e[3];
    for (int i = 0; i < 3; ++i) e[i] = D::variable(spectrum.half_log[i], i);
    const std::array<D, 3> mapped = map(e, D::variable(beside.value(), 3)...);
    Real values[3];
    for (std::size_t i = 0; i < 3; ++i) values[i] = mapped[i].value;
    const V composed = spectrum.compose(values);
    const V Q = spectrum.directions();
    // Of the change in the basis Q: on the diagonal sum_j along_ij dh_jj, off it across_ij dh_ij.
    Real along[3][3], across[3][3];
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) along[i][j] = mapped[static_cast<std::size_t>(i)].d[j] / (2 * (1 + spectrum.value[j]));
    }
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const Real apart = spectrum.value[i] - spectrum.value[j];
        across[i][j] = std::abs(apart) < k_equal * (1 + spectrum.value[i]) ? 0.5 * (along[i][i] - along[i][j] + along[j][j] - along[j][i])
                                                                           : (values[i] - values[j]) / apart;
      }
    }
    M result;
    for (int k = 0; k < V::k_size; ++k) result.entries[k] = T(composed.entries[k]);
    const auto count = h.entries[0].derivatives().size();
    for (decltype(h.entries[0].derivatives().size()) n = 0; n < count; ++n) {
      V change;
      for (int k = 0; k < V::k_size; ++k) change.entries[k] = h.entries[k].derivatives()[n];
      const V in_basis = transpose(Q) * change * Q;
      V changed = V::zero();
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          if (!V::is_stored(i, j)) continue;
          if (i != j) {
            changed(i, j) = across[i][j] * in_basis(i, j);
            continue;
          }
          for (int m = 0; m < 3; ++m) changed(i, i) += along[i][m] * in_basis(m, m);
          if constexpr (k_count > 3) changed(i, i) += (... + (mapped[static_cast<std::size_t>(i)].d[3] * beside.derivatives()[n]));
        }
      }
      const V back = Q * changed * transpose(Q);
      for (int k = 0; k < V::k_size; ++k) result.entries[k].derivatives()[n] = back.entries[k];
    }
    return result;
  }
}

/// A power series sum c_k a^(k+1) of a symmetric tensor, given as xx yy zz xy yz xz: by Horner's scheme, where Cayley and Hamilton's
/// a^3 = I1 a^2 - I2 a + I3 leaves three numbers to be carried along.
template <class T, std::size_t n>
std::array<T, 6> power_series(const std::array<T, 6>& a, const std::array<Real, n>& c) {
  const auto& [xx, yy, zz, xy, yz, xz] = a;
  const std::array<T, 6> square = {T(xx * xx + xy * xy + xz * xz), T(xy * xy + yy * yy + yz * yz), T(xz * xz + yz * yz + zz * zz),
                                   T(xx * xy + xy * yy + xz * yz), T(xy * xz + yy * yz + yz * zz), T(xx * xz + xy * yz + xz * zz)};
  const T I1 = T(xx + yy + zz);
  const T I2 = T(0.5 * (I1 * I1 - (square[0] + square[1] + square[2])));
  const T I3 = T(xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz));
  T A = T(0.0), B = T(0.0), C = T(c[n - 1]);
  const auto times_a = [&] {
    const T next_A = T(A * I1 + B);
    const T next_B = T(C - A * I2);
    C = T(A * I3);
    A = next_A;
    B = next_B;
  };
  for (std::size_t k = n - 1; k-- > 0;) {
    times_a();
    C = T(C + T(c[k]));
  }
  times_a();
  std::array<T, 6> result;
  for (std::size_t i = 0; i < 6; ++i) result[i] = T(A * square[i] + B * a[i]);
  for (std::size_t i = 0; i < 3; ++i) result[i] = T(result[i] + C);
  return result;
}
/// The same in the plane, given as xx yy zz xy: a^2 = I1 a - I2 there, and zz is a number.
template <class T, std::size_t n>
std::array<T, 4> power_series(const std::array<T, 4>& a, const std::array<Real, n>& c) {
  const auto& [xx, yy, zz, xy] = a;
  const T I1 = T(xx + yy);
  const T I2 = T(xx * yy - xy * xy);
  T B = T(0.0), C = T(c[n - 1]), out = T(c[n - 1]);
  const auto times_a = [&] {
    const T next = T(B * I1 + C);
    C = T(-(B * I2));
    B = next;
  };
  for (std::size_t k = n - 1; k-- > 0;) {
    times_a();
    C = T(C + T(c[k]));
    out = T(out * zz + T(c[k]));
  }
  times_a();
  return {T(B * xx + C), T(B * yy + C), T(out * zz), T(B * xy)};
}
/// ln(I + h)/2 and exp(2 e) - I for tensors of Frobenius norm to `k_series_norm`, to the last digits.
constexpr Real k_series_norm = 0.1;
template <class T, std::size_t size>
std::array<T, size> half_log1p_of_small(const std::array<T, size>& h) {
  std::array<Real, 15> c;
  for (std::size_t k = 0; k < c.size(); ++k) c[k] = (k % 2 == 0 ? 0.5 : -0.5) / static_cast<Real>(k + 1);
  return power_series(h, c);
}
template <class T, std::size_t size>
std::array<T, size> expm1_of_small(const std::array<T, size>& twice_e) {
  std::array<Real, 10> c;
  Real factorial = 1;
  for (std::size_t k = 0; k < c.size(); ++k) c[k] = 1 / (factorial *= static_cast<Real>(k + 1));
  return power_series(twice_e, c);
}

/// A symmetric tensor as a law remembers it, xx yy zz xy (yz xz), and back.
template <class M>
M unpacked(const typename M::Scalar* components) {
  M a;
  for (int d = 0; d < 3; ++d) a(d, d) = components[d];
  a(0, 1) = a(1, 0) = components[3];
  if constexpr (M::k_size == 9) {
    a(1, 2) = a(2, 1) = components[4];
    a(0, 2) = a(2, 0) = components[5];
  }
  return a;
}
template <class M>
void pack(const M& a, typename M::Scalar* components) {
  for (int d = 0; d < 3; ++d) components[d] = a(d, d);
  components[3] = a(0, 1);
  if constexpr (M::k_size == 9) {
    components[4] = a(1, 2);
    components[5] = a(0, 2);
  }
}

/// F F^T - I, with the digits of F - I.
template <class T, bool is_plane>
Mat3<T, is_plane> left_cauchy_green_minus_identity(const Mat3<T, is_plane>& F) {
  const Mat3<T, is_plane> g = F - Mat3<T, is_plane>::identity();
  return g + transpose(g) + g * transpose(g);
}

}  // namespace matpoint
