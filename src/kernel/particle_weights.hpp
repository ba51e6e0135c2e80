// Weights of one particle, of any shape: for what is not done for many particles at once.
#pragma once

#include "kernel/domain.hpp"

namespace matpoint {
namespace {

/// For shapes that are products.
template <int Dim, class R, class Shape>
class ParticleWeights {
 public:
  static constexpr int n = Shape::k_nodes;
  /// x: the place in the cell. The rest is for convected domains.
  ParticleWeights(const Shape* shapes, const R* x, const R (&)[Dim][Dim]) {
    for (int d = 0; d < Dim; ++d) {
      shapes[d].weights(x[d], N_[d], dN_[d]);
      centre_[d] = shapes[d].centre(x[d]);
    }
  }
  /// Along x for a row of nodes: N_i, and its derivatives in xi.
  void of_row(int row, R* N, R (&dN)[Dim][n]) const {
    for (int i = 0; i < n; ++i) {
      const int index[3] = {i, row % n, row / n};
      N[i] = 1;
      for (int d = 0; d < Dim; ++d) {
        N[i] *= N_[d][index[d]];
        dN[d][i] = 1;
        for (int e = 0; e < Dim; ++e) dN[d][i] *= e == d ? dN_[e][index[e]] : N_[e][index[e]];
      }
    }
  }
  /// sum N_i x_i
  R centre(int d) const { return centre_[d]; }

 private:
  R N_[Dim][n];
  R dN_[Dim][n];
  R centre_[Dim];
};

template <int Dim, class R>
class ParticleWeights<Dim, R, ShapeConvected<R>> {
 public:
  static constexpr int n = ShapeConvected<R>::k_nodes;
  /// edges: half of those of the domain, one per column, in cell sides.
  ParticleWeights(const ShapeConvected<R>* shapes, const R* x, const R (&edges)[Dim][Dim]) : domain_(shapes, x, edges) {}
  void of_row(int row, R* N, R (&dN)[Dim][n]) const {
    const int node[3] = {0, row % n, row / n};
    domain_.weights_of_row(node, N, dN);
  }
  R centre(int d) const { return domain_.centre(d); }

 private:
  ConvectedDomain<Dim, R> domain_;
};

}  // namespace
}  // namespace matpoint
