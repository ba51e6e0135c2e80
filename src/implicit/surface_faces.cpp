#include "implicit/surface_faces.hpp"

#include <algorithm>
#include <cmath>

#include "implicit/point_kernels.hpp"

namespace matpoint {
namespace {

/// Of the cells of each field: place of the first entry among the active ones, or -1.
template <int Dim>
class Entries {
 public:
  explicit Entries(const StepSpace<Dim>& space)
      : space_(space), all_(static_cast<std::size_t>(space.basis().cell_count()) * space.field_count(), -1) {
    for (std::size_t c = 0; c < space.cells().size(); ++c) {
      if (!space.is_again(c)) all_[place(c, space.cells()[c])] = static_cast<Index>(c);
    }
  }
  /// Of a cell in the field of an entry.
  Index beside(std::size_t c, Index cell) const { return all_[place(c, cell)]; }

 private:
  std::size_t place(std::size_t c, Index cell) const {
    return space_.field_of(space_.source_of(c)) * static_cast<std::size_t>(space_.basis().cell_count()) + static_cast<std::size_t>(cell);
  }
  const StepSpace<Dim>& space_;
  std::vector<Index> all_;
};

/// Of a cell [m]; splines have boxes.
template <int Dim>
Vec<Dim> sides_of(const Basis<Dim>& basis, Index cell) {
  ElementPoint<Dim> lower{cell, {}}, upper{cell, {}};
  lower.xi.fill(-1);
  upper.xi.fill(1);
  Vec<Dim> sides;
  for (std::size_t d = 0; d < Dim; ++d) sides[d] = basis.position(upper)[d] - basis.position(lower)[d];
  return sides;
}

template <int Dim>
Real volume_of(const Vec<Dim>& sides) {
  Real volume = 1;
  for (const Real side : sides) volume *= side;
  return volume;
}

/// Second derivatives of a cell's functions along an axis, on the face at one end of it: they are constant along the axis.
template <int Dim>
std::vector<Real> second_derivatives(const Basis<Dim>& basis, Index cell, int axis, const Vec<Dim>& xi) {
  const auto functions = static_cast<std::size_t>(basis.functions_per_cell());
  std::vector<Real> N(functions), upper(functions * Dim), lower(functions * Dim);
  ElementPoint<Dim> point{cell, xi};
  point.xi[static_cast<std::size_t>(axis)] = 1;
  basis.evaluate(point, N.data(), upper.data());
  point.xi[static_cast<std::size_t>(axis)] = -1;
  basis.evaluate(point, N.data(), lower.data());
  const Real side = sides_of(basis, cell)[static_cast<std::size_t>(axis)];
  std::vector<Real> second(functions);
  for (std::size_t k = 0; k < functions; ++k)
    second[k] = (upper[k * Dim + static_cast<std::size_t>(axis)] - lower[k * Dim + static_cast<std::size_t>(axis)]) / side;
  return second;
}

template <int Dim>
SurfaceFace<Dim> make_face(const StepSpace<Dim>& space, std::size_t c, std::size_t other, int axis) {
  const Basis<Dim>& basis = space.basis();
  SurfaceFace<Dim> face;
  face.source = space.source_of(c);
  face.cells[0] = c;
  face.cells[1] = other;
  const auto functions = static_cast<std::size_t>(space.functions());
  face.nodes.assign(space.cell_nodes(c), space.cell_nodes(c) + functions);
  face.nodes.insert(face.nodes.end(), space.cell_nodes(other), space.cell_nodes(other) + functions);
  std::sort(face.nodes.begin(), face.nodes.end());
  face.nodes.erase(std::unique(face.nodes.begin(), face.nodes.end()), face.nodes.end());
  const std::size_t n = face.nodes.size();
  face.stiffness.assign(n * n, 0);
  // Gauss's rule with three points per direction of the face: products of quadratic functions.
  const Real places[3] = {-std::sqrt(0.6), 0, std::sqrt(0.6)};
  const Real weights[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
  Vec<Dim> xi{};
  const Vec<Dim> sides = sides_of(basis, space.cells()[c]);
  const Real h = sides[static_cast<std::size_t>(axis)];
  const Real area = volume_of<Dim>(sides) / h;
  for (int q = 0; q < whole_power(3, Dim - 1); ++q) {
    Real weight = area * h * h * h;
    for (int d = 0, rest = q; d < Dim; ++d) {
      if (d == axis) continue;
      xi[static_cast<std::size_t>(d)] = places[rest % 3];
      weight *= weights[rest % 3];
      rest /= 3;
    }
    std::vector<Real> jump(n, 0);
    for (const std::size_t cell : {c, other}) {
      const std::vector<Real> second = second_derivatives<Dim>(basis, space.cells()[cell], axis, xi);
      for (std::size_t k = 0; k < functions; ++k) {
        const auto at = std::lower_bound(face.nodes.begin(), face.nodes.end(), space.cell_nodes(cell)[k]) - face.nodes.begin();
        jump[static_cast<std::size_t>(at)] += cell == c ? -second[k] : second[k];
      }
    }
    for (std::size_t I = 0; I < n; ++I) {
      for (std::size_t K = 0; K < n; ++K) face.stiffness[I * n + K] += weight * jump[I] * jump[K];
    }
  }
  return face;
}

/// Whether a condition ends between the nodes of a line across the face: what it holds is no polynomial of the body, and penalising it
/// would brake a body that comes near.
template <int Dim>
bool crosses_a_condition(const StepSpace<Dim>& space, const SurfaceFace<Dim>& face, int axis) {
  const auto is_held = [&](int n, int d) { return space.conditions().condition(space.nodes()[static_cast<std::size_t>(n)], d) >= 0; };
  for (const int a : face.nodes) {
    const Vec<Dim> x = space.basis().node_position(space.nodes()[static_cast<std::size_t>(a)]);
    for (const int b : face.nodes) {
      const Vec<Dim> y = space.basis().node_position(space.nodes()[static_cast<std::size_t>(b)]);
      bool is_one_line = true;
      for (std::size_t d = 0; d < Dim; ++d) is_one_line = is_one_line && (static_cast<int>(d) == axis || x[d] == y[d]);
      for (int d = 0; d < Dim && is_one_line; ++d) {
        if (is_held(a, d) != is_held(b, d)) return true;
      }
    }
  }
  return false;
}

}  // namespace

template <int Dim>
std::vector<SurfaceFace<Dim>> surface_faces(const StepSpace<Dim>& space) {
  std::vector<SurfaceFace<Dim>> faces;
  const Basis<Dim>& basis = space.basis();
  if (basis.is_interpolating()) return faces;
  const Entries<Dim> entries(space);
  std::vector<bool> is_surface(space.cells().size(), false);
  for (std::size_t c = 0; c < is_surface.size(); ++c) {
    for (int axis = 0; axis < Dim; ++axis) {
      for (const bool is_upper : {false, true}) {
        const Index other = basis.neighbour(space.cells()[c], axis, is_upper);
        if (other >= 0 && entries.beside(c, other) < 0) is_surface[c] = true;
      }
    }
  }
  for (std::size_t c = 0; c < is_surface.size(); ++c) {
    if (space.is_again(c)) continue;
    for (int axis = 0; axis < Dim; ++axis) {
      const Index other = basis.neighbour(space.cells()[c], axis, true);
      const Index entry = other < 0 ? -1 : entries.beside(c, other);
      if (entry < 0 || (!is_surface[c] && !is_surface[static_cast<std::size_t>(entry)])) continue;
      SurfaceFace<Dim> face = make_face(space, c, static_cast<std::size_t>(entry), axis);
      if (!crosses_a_condition(space, face, axis)) faces.push_back(std::move(face));
    }
  }
  return faces;
}

template <int Dim>
void measure_emptiness(const StepSpace<Dim>& space, std::vector<SurfaceFace<Dim>>& faces) {
  for (SurfaceFace<Dim>& face : faces) {
    face.emptiness = 0;
    for (const std::size_t first : face.cells) {
      Real filled = 0;
      for (std::size_t c = first; c < space.cells().size() && (c == first || space.is_again(c)); ++c) {
        const PointBody<Dim>& body = *space.sources()[space.source_of(c)].points;
        for (Index k = space.cell_begin(c); k < space.cell_end(c); ++k) {
          const auto p = static_cast<std::size_t>(space.particles()[static_cast<std::size_t>(k)]);
          filled += body.volume0[p] * determinant_of<Dim>(body.F.data() + p * Dim * Dim);
        }
      }
      face.emptiness = std::max(face.emptiness, 1 - filled / volume_of<Dim>(sides_of(space.basis(), space.cells()[first])));
    }
  }
}

template std::vector<SurfaceFace<2>> surface_faces<2>(const StepSpace<2>&);
template std::vector<SurfaceFace<3>> surface_faces<3>(const StepSpace<3>&);
template void measure_emptiness<2>(const StepSpace<2>&, std::vector<SurfaceFace<2>>&);
template void measure_emptiness<3>(const StepSpace<3>&, std::vector<SurfaceFace<3>>&);

}  // namespace matpoint
