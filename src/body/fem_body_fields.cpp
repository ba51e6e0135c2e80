// What a body of finite elements shows at its nodes: its motion as it is, and what its Gauss points carry extended to the nodes.
#include <algorithm>
#include <array>
#include <cmath>

#include "body/fem_body.hpp"
#include "body/particle_fields.hpp"
#include "core/error.hpp"

namespace matpoint {
namespace {

/// Places of VTK's nodes in a cell, counted from 0 along x, y (and z): corners, middles of edges, of faces, of the cell.
template <int Dim>
std::vector<std::array<int, Dim>> vtk_places(bool is_quadratic);

template <>
std::vector<std::array<int, 2>> vtk_places<2>(bool is_quadratic) {
  if (!is_quadratic) return {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  return {{0, 0}, {2, 0}, {2, 2}, {0, 2}, {1, 0}, {2, 1}, {1, 2}, {0, 1}, {1, 1}};
}

template <>
std::vector<std::array<int, 3>> vtk_places<3>(bool is_quadratic) {
  if (!is_quadratic) return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  return {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2}, {2, 0, 2}, {2, 2, 2}, {0, 2, 2}, {1, 0, 0},
          {2, 1, 0}, {1, 2, 0}, {0, 1, 0}, {1, 0, 2}, {2, 1, 2}, {1, 2, 2}, {0, 1, 2}, {0, 0, 1}, {2, 0, 1},
          {2, 2, 1}, {0, 2, 1}, {0, 1, 1}, {2, 1, 1}, {1, 0, 1}, {1, 2, 1}, {1, 1, 0}, {1, 1, 2}, {1, 1, 1}};
}

/// VTK_QUAD, VTK_BIQUADRATIC_QUAD, VTK_HEXAHEDRON, VTK_TRIQUADRATIC_HEXAHEDRON.
int vtk_type(int dim, bool is_quadratic) { return dim == 2 ? (is_quadratic ? 28 : 9) : (is_quadratic ? 29 : 12); }

/// Values at xi of the parabolas that are 1 at one of three Gauss points and 0 at the others.
std::array<Real, 3> gauss_parabolas(Real xi) {
  constexpr Real g2 = 0.6;
  const Real g = std::sqrt(g2);
  return {xi * (xi - g) / (2 * g2), 1 - xi * xi / g2, xi * (xi + g) / (2 * g2)};
}

}  // namespace

template <int Dim>
BodyCells FemBody<Dim>::make_cells() const {
  const bool is_quadratic = functions_ == whole_power(3, Dim);
  const int per_axis = is_quadratic ? 3 : 2;
  BodyCells cells{vtk_type(Dim, is_quadratic), functions_, {}};
  const auto places = vtk_places<Dim>(is_quadratic);
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    for (const std::array<int, Dim>& place : places) {
      Index local = 0;
      for (std::size_t d = Dim; d-- > 0;) local = local * per_axis + place[d];
      cells.nodes.push_back(cell_rows_[c * static_cast<std::size_t>(functions_) + static_cast<std::size_t>(local)]);
    }
  }
  return cells;
}

template <int Dim>
std::vector<std::string> FemBody<Dim>::node_field_names() const {
  std::vector<std::string> names = {"position", "displacement"};
  for (const std::string& name : particle_field_names(points_.material())) {
    if (name != "position" && name != "id" && name != "mass" && name != "volume") names.push_back(name);
  }
  return names;
}

/// In each cell the field that is a parabola in each direction through its Gauss points, or, where it is `bounded`, what of it is in their
/// range; at nodes of several cells their mean.
template <int Dim>
Field FemBody<Dim>::extended_to_nodes(const Field& at_points, bool is_bounded) const {
  constexpr std::size_t k_points = whole_power(3, Dim);
  const auto components = static_cast<std::size_t>(at_points.components);
  const auto functions = static_cast<std::size_t>(functions_);
  const int per_axis = functions_ == whole_power(3, Dim) ? 3 : 2;
  std::vector<Real> share(functions * k_points, 1);
  for (std::size_t local = 0; local < functions; ++local) {
    for (std::size_t q = 0; q < k_points; ++q) {
      std::size_t node_rest = local, point_rest = q;
      for (int d = 0; d < Dim; ++d) {
        const Real xi = 2.0 * static_cast<Real>(node_rest % static_cast<std::size_t>(per_axis)) / (per_axis - 1) - 1;
        share[local * k_points + q] *= gauss_parabolas(xi)[point_rest % 3];
        node_rest /= static_cast<std::size_t>(per_axis);
        point_rest /= 3;
      }
    }
  }
  Field field{at_points.name, at_points.unit, at_points.components, std::vector<Real>(nodes_of_body_.size() * components, 0)};
  std::vector<Real> count(nodes_of_body_.size(), 0);
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    for (std::size_t local = 0; local < functions; ++local) {
      const auto row = static_cast<std::size_t>(cell_rows_[c * functions + local]);
      ++count[row];
      for (std::size_t k = 0; k < components; ++k) {
        Real value = 0, least = std::numeric_limits<Real>::infinity(), most = -least;
        for (std::size_t q = 0; q < k_points; ++q) {
          const Real at_point = at_points.values[(c * k_points + q) * components + k];
          value += share[local * k_points + q] * at_point;
          least = std::min(least, at_point);
          most = std::max(most, at_point);
        }
        field.values[row * components + k] += is_bounded ? std::clamp(value, least, most) : value;
      }
    }
  }
  for (std::size_t i = 0; i < field.values.size(); ++i) field.values[i] /= count[i / components];
  return field;
}

template <int Dim>
Field FemBody<Dim>::node_field(const std::string& name, std::size_t body) const {
  const auto at_nodes = [&](const char* unit, const auto& vector_of) {
    Field field{name, unit, Dim, {}};
    for (const Index node : nodes_of_body_) {
      const Vec<Dim> value = vector_of(static_cast<std::size_t>(node));
      field.values.insert(field.values.end(), value.begin(), value.end());
    }
    return field;
  };
  if (name == "displacement") return at_nodes("m", [&](std::size_t node) { return displacement[node]; });
  if (name == "velocity") return at_nodes("m/s", [&](std::size_t node) { return velocity[node]; });
  if (name == "position") {
    Field field = at_nodes("m", [&](std::size_t node) { return displacement[node]; });
    for (std::size_t i = 0; i < field.values.size(); ++i) field.values[i] += undeformed_[i / Dim][i % Dim];
    return field;
  }
  if (name == "von_mises") {  // of the extended stress: extended by itself it could be negative
    const Field stress = extended_to_nodes(points_.field("stress", body));
    Field field{name, stress.unit, 1, {}};
    for (std::size_t row = 0; row < nodes_of_body_.size(); ++row) {
      std::array<Real, 6> sigma;
      std::copy_n(stress.values.begin() + static_cast<std::ptrdiff_t>(6 * row), 6, sigma.begin());
      field.values.push_back(von_mises(sigma));
    }
    return field;
  }
  if (name == "id" || name == "mass" || name == "volume")
    throw InputError("body \"{}\": {} is a field of particles and Gauss points, not of nodes", points_.name(), name);
  const std::vector<std::string> names = node_field_names();
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    throw InputError("body \"{}\" has no field \"{}\" at its nodes, it has {}{}", points_.name(), name, list_names(names),
                     did_you_mean(name, names));
  }
  // What a law remembers may have bounds, as a damage has, that a parabola does not know.
  const std::vector<InternalVariable> remembered = points_.material().internal_variables();
  const bool is_remembered =
      std::any_of(remembered.begin(), remembered.end(), [&](const InternalVariable& one) { return one.name == name; });
  return extended_to_nodes(points_.field(name, body), is_remembered);
}

template class FemBody<2>;
template class FemBody<3>;

}  // namespace matpoint
