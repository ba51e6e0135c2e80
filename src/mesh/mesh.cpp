#include "mesh/mesh.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"

namespace matpoint {
namespace {

constexpr const char* k_side_names[3][2] = {{"left", "right"}, {"bottom", "top"}, {"front", "back"}};

/// Solves the Dim x Dim system a x = b; `a` must be regular. Returns the determinant.
template <int Dim>
Real solve_small(const Real a[Dim][Dim], const Vec<Dim>& b, Vec<Dim>& x) {
  if constexpr (Dim == 2) {
    const Real det = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    x = {(b[0] * a[1][1] - b[1] * a[0][1]) / det, (a[0][0] * b[1] - a[1][0] * b[0]) / det};
    return det;
  } else {
    Real cofactors[3][3];
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
        cofactors[r][c] = a[r1][c1] * a[r2][c2] - a[r1][c2] * a[r2][c1];
      }
    }
    const Real det = a[0][0] * cofactors[0][0] + a[0][1] * cofactors[0][1] + a[0][2] * cofactors[0][2];
    for (std::size_t c = 0; c < 3; ++c) x[c] = (cofactors[0][c] * b[0] + cofactors[1][c] * b[1] + cofactors[2][c] * b[2]) / det;
    return det;
  }
}

/// Local node number to its place along each direction.
template <int Dim>
std::array<int, Dim> places_of(int local, int order) {
  std::array<int, Dim> places;
  for (int& place : places) {
    place = local % (order + 1);
    local /= order + 1;
  }
  return places;
}

}  // namespace

Lagrange::Lagrange(int order, Real xi) {
  if (order == 1) {
    N[0] = 0.5 * (1 - xi);
    N[1] = 0.5 * (1 + xi);
    N[2] = 0;
    dN[0] = -0.5;
    dN[1] = 0.5;
    dN[2] = 0;
  } else {
    N[0] = 0.5 * xi * (xi - 1);
    N[1] = 1 - xi * xi;
    N[2] = 0.5 * xi * (xi + 1);
    dN[0] = xi - 0.5;
    dN[1] = -2 * xi;
    dN[2] = xi + 0.5;
  }
}

template <int Dim>
Mesh<Dim>::Mesh(int order, std::vector<Vec<Dim>> nodes, std::vector<Index> elements, std::map<std::string, std::vector<ElementFace>> parts)
    : order_(order),
      nodes_per_element_(whole_power(order + 1, Dim)),
      nodes_(std::move(nodes)),
      elements_(std::move(elements)),
      parts_(std::move(parts)) {
  if (elements_.empty()) throw InputError("mesh: it has no element");
  if (elements_.size() % static_cast<std::size_t>(nodes_per_element_) != 0)
    throw InputError("mesh: {} node numbers are not a multiple of {} per element", elements_.size(), nodes_per_element_);
  for (std::size_t k = 0; k < elements_.size(); ++k) {
    if (elements_[k] >= 0 && elements_[k] < node_count()) continue;
    throw InputError("mesh: element {} has node {}, but there are nodes 0 to {}", k / static_cast<std::size_t>(nodes_per_element_),
                     elements_[k], node_count() - 1);
  }
  std::vector<Real> N(static_cast<std::size_t>(nodes_per_element_));
  std::vector<Real> gradients(N.size() * Dim);
  for (Index e = 0; e < element_count(); ++e) {
    for (int local = 0; local < nodes_per_element_; ++local) {
      ElementPoint<Dim> point{e, {}};
      const auto places = places_of<Dim>(local, order_);
      for (std::size_t d = 0; d < Dim; ++d) point.xi[d] = 2.0 * places[d] / order_ - 1;
      const Real det = evaluate(point, N.data(), gradients.data());
      if (det > 0) continue;
      throw InputError("mesh: element {} is turned inside out at its node {} (Jacobian {:.6g}); number its nodes counter-clockwise", e,
                       element(e)[local], det);
    }
  }
  find_neighbours();
  fill_bins();
}

template <int Dim>
std::vector<Index> Mesh<Dim>::face_nodes(const ElementFace& face) const {
  std::vector<Index> found;
  for (int local = 0; local < nodes_per_element_; ++local) {
    const int place = places_of<Dim>(local, order_)[static_cast<std::size_t>(face.axis)];
    if (place == (face.is_upper ? order_ : 0)) found.push_back(element(face.element)[local]);
  }
  return found;
}

template <int Dim>
void Mesh<Dim>::find_neighbours() {
  neighbours_.assign(static_cast<std::size_t>(element_count() * 2 * Dim), -1);
  std::map<std::vector<Index>, std::pair<Index, int>> open;
  for (Index e = 0; e < element_count(); ++e) {
    for (int side = 0; side < 2 * Dim; ++side) {
      std::vector<Index> key = face_nodes({e, side / 2, side % 2 == 1});
      std::sort(key.begin(), key.end());
      const auto [other, is_new] = open.try_emplace(std::move(key), e, side);
      if (is_new) continue;
      neighbours_[static_cast<std::size_t>(e * 2 * Dim + side)] = other->second.first;
      neighbours_[static_cast<std::size_t>(other->second.first * 2 * Dim + other->second.second)] = e;
      open.erase(other);
    }
  }
}

template <int Dim>
std::vector<Index> Mesh<Dim>::boundary_nodes() const {
  std::vector<Index> found;
  for (Index e = 0; e < element_count(); ++e) {
    for (int side = 0; side < 2 * Dim; ++side) {
      if (neighbours_[static_cast<std::size_t>(e * 2 * Dim + side)] >= 0) continue;
      const std::vector<Index> nodes = face_nodes({e, side / 2, side % 2 == 1});
      found.insert(found.end(), nodes.begin(), nodes.end());
    }
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

template <int Dim>
void Mesh<Dim>::set_nodes(std::vector<Vec<Dim>> nodes) {
  nodes_ = std::move(nodes);
  fill_bins();
}

template <int Dim>
void Mesh<Dim>::fill_bins() {
  Vec<Dim> upper{};
  for (std::size_t d = 0; d < Dim; ++d) {
    const auto [least, greatest] =
        std::minmax_element(nodes_.begin(), nodes_.end(), [&](const auto& a, const auto& b) { return a[d] < b[d]; });
    bin_lower_[d] = (*least)[d];
    upper[d] = (*greatest)[d];
    bin_count_[d] = std::max(1, static_cast<int>(std::pow(static_cast<Real>(element_count()), 1.0 / Dim)));
    bin_size_[d] = (upper[d] - bin_lower_[d]) / bin_count_[d];
  }
  bins_.assign(static_cast<std::size_t>(whole_power(bin_count_[0], Dim)), {});
  for (Index e = 0; e < element_count(); ++e) {
    std::array<int, Dim> first;
    std::array<int, Dim> last;
    for (std::size_t d = 0; d < Dim; ++d) {
      Real low = std::numeric_limits<Real>::infinity();
      Real high = -low;
      for (int local = 0; local < nodes_per_element_; ++local) {
        low = std::min(low, nodes_[static_cast<std::size_t>(element(e)[local])][d]);
        high = std::max(high, nodes_[static_cast<std::size_t>(element(e)[local])][d]);
      }
      // Curved sides may bulge over their nodes.
      const Real margin = 0.25 * (high - low);
      const auto bin_at = [&](Real x) { return std::clamp(static_cast<int>((x - bin_lower_[d]) / bin_size_[d]), 0, bin_count_[d] - 1); };
      first[d] = bin_at(low - margin);
      last[d] = bin_at(high + margin);
    }
    std::array<int, Dim> bin = first;
    while (true) {
      std::size_t number = 0;
      for (std::size_t d = Dim; d-- > 0;) number = number * static_cast<std::size_t>(bin_count_[d]) + static_cast<std::size_t>(bin[d]);
      bins_[number].push_back(e);
      std::size_t d = 0;
      while (d < Dim && bin[d] == last[d]) {
        bin[d] = first[d];
        ++d;
      }
      if (d == Dim) break;
      ++bin[d];
    }
  }
}

template <int Dim>
Real Mesh<Dim>::evaluate(const ElementPoint<Dim>& point, Real* N, Real* gradients) const {
  const Index* const numbers = element(point.element);
  Real local_gradients[27][Dim];
  Real jacobian[Dim][Dim] = {};  // dx_r / dxi_c
  Lagrange along[Dim];
  for (std::size_t d = 0; d < Dim; ++d) along[d] = Lagrange(order_, point.xi[d]);
  for (int local = 0; local < nodes_per_element_; ++local) {
    const auto places = places_of<Dim>(local, order_);
    N[local] = 1;
    for (std::size_t d = 0; d < Dim; ++d) {
      N[local] *= along[d].N[places[d]];
      Real derivative = 1;
      for (std::size_t e = 0; e < Dim; ++e) derivative *= d == e ? along[e].dN[places[e]] : along[e].N[places[e]];
      local_gradients[local][d] = derivative;
    }
    const Vec<Dim>& x = nodes_[static_cast<std::size_t>(numbers[local])];
    for (std::size_t r = 0; r < Dim; ++r) {
      for (std::size_t c = 0; c < Dim; ++c) jacobian[r][c] += x[r] * local_gradients[local][c];
    }
  }
  // grad N = J^-T dN/dxi
  Real transposed[Dim][Dim];
  for (int r = 0; r < Dim; ++r) {
    for (int c = 0; c < Dim; ++c) transposed[r][c] = jacobian[c][r];
  }
  Real det = 0;
  for (int local = 0; local < nodes_per_element_; ++local) {
    Vec<Dim> right;
    std::copy_n(local_gradients[local], Dim, right.begin());
    Vec<Dim> gradient;
    det = solve_small<Dim>(transposed, right, gradient);
    std::copy_n(gradient.begin(), Dim, gradients + local * Dim);
  }
  return det;
}

template <int Dim>
Vec<Dim> Mesh<Dim>::position(const ElementPoint<Dim>& point) const {
  Vec<Dim> x{};
  Lagrange along[Dim];
  for (std::size_t d = 0; d < Dim; ++d) along[d] = Lagrange(order_, point.xi[d]);
  for (int local = 0; local < nodes_per_element_; ++local) {
    const auto places = places_of<Dim>(local, order_);
    Real N = 1;
    for (std::size_t d = 0; d < Dim; ++d) N *= along[d].N[places[d]];
    const Vec<Dim>& node = nodes_[static_cast<std::size_t>(element(point.element)[local])];
    for (std::size_t d = 0; d < Dim; ++d) x[d] += N * node[d];
  }
  return x;
}

/// The element itself, or a neighbour with a greater number on whose face the point is.
template <int Dim>
Index Mesh<Dim>::owner_of(const ElementPoint<Dim>& point, const std::vector<bool>* is_barred) const {
  Index owner = point.element;
  for (std::size_t d = 0; d < Dim; ++d) {
    if (std::abs(point.xi[d]) < 1 - k_on_face) continue;
    const Index other = neighbour(point.element, static_cast<int>(d), point.xi[d] > 0);
    if (is_barred != nullptr && other >= 0 && (*is_barred)[static_cast<std::size_t>(other)]) continue;
    owner = std::max(owner, other);
  }
  return owner;
}

template <int Dim>
std::optional<ElementPoint<Dim>> Mesh<Dim>::locate(const Vec<Dim>& x, Index guess, const std::vector<bool>* is_barred) const {
  constexpr Real k_converged = 1e-13;
  constexpr Real k_nearly_converged = 1e-9;  // and no longer falling: far from the origin rounding ends it sooner
  constexpr int k_iterations = 30;
  const int hops_max = 4 + static_cast<int>(2 * element_count());  // more than any way without a loop
  ElementPoint<Dim> point{guess, {}};
  Real N[27];
  Real gradients[27 * Dim];
  for (int hop = 0; hop < hops_max; ++hop) {
    bool has_converged = false;
    Real last_change = std::numeric_limits<Real>::infinity();
    for (int iteration = 0; iteration < k_iterations && !has_converged; ++iteration) {
      // With grad N = J^-T dN/dxi: dxi = J^-1 (x - x(xi)); J^-1_dr is the gradient of xi_d, which the nodes' xi interpolate exactly.
      const Vec<Dim> reached = position(point);
      evaluate(point, N, gradients);
      Vec<Dim> change{};
      for (int local = 0; local < nodes_per_element_; ++local) {
        const auto places = places_of<Dim>(local, order_);
        for (std::size_t d = 0; d < Dim; ++d) {
          const Real xi_node = 2.0 * places[d] / order_ - 1;
          for (std::size_t r = 0; r < Dim; ++r)
            change[d] += xi_node * gradients[static_cast<std::size_t>(local) * Dim + r] * (x[r] - reached[r]);
        }
      }
      Real largest = 0;
      for (std::size_t d = 0; d < Dim; ++d) {
        point.xi[d] += change[d];
        largest = std::max(largest, std::abs(change[d]));
        // Far outside the map may fold; the direction of the hop is all that is asked for there.
        point.xi[d] = std::clamp(point.xi[d], Real{-3}, Real{3});
      }
      has_converged = largest < k_converged || (largest < k_nearly_converged && largest >= last_change);
      last_change = largest;
    }
    std::size_t worst = 0;
    for (std::size_t d = 1; d < Dim; ++d) {
      if (std::abs(point.xi[d]) > std::abs(point.xi[worst])) worst = d;
    }
    if (std::abs(point.xi[worst]) <= 1 + k_on_face) {
      if (!has_converged) return std::nullopt;
      const Index owner = owner_of(point, is_barred);
      if (owner == point.element) return point;
      point = {owner, {}};
      continue;
    }
    const Index next = neighbour(point.element, static_cast<int>(worst), point.xi[worst] > 0);
    if (next < 0) return std::nullopt;
    if (is_barred != nullptr && (*is_barred)[static_cast<std::size_t>(next)]) return has_converged ? std::optional(point) : std::nullopt;
    point = {next, {}};
  }
  return std::nullopt;
}

template <int Dim>
std::optional<ElementPoint<Dim>> Mesh<Dim>::locate(const Vec<Dim>& x) const {
  std::size_t number = 0;
  for (std::size_t d = Dim; d-- > 0;) {
    if (!std::isfinite(x[d])) return std::nullopt;
    const int bin =
        std::clamp(static_cast<int>(std::clamp((x[d] - bin_lower_[d]) / bin_size_[d], Real{-1}, Real{1e9})), 0, bin_count_[d] - 1);
    number = number * static_cast<std::size_t>(bin_count_[d]) + static_cast<std::size_t>(bin);
  }
  for (const Index e : bins_[number]) {
    if (const auto found = locate(x, e)) return found;
  }
  return std::nullopt;
}

template <int Dim>
Mesh<Dim> tensor_mesh(const std::array<std::vector<Real>, Dim>& lines, int order) {
  std::array<std::vector<Real>, Dim> along;  // coordinates of the nodes
  std::array<Index, Dim> cells;
  for (std::size_t d = 0; d < Dim; ++d) {
    cells[d] = static_cast<Index>(lines[d].size()) - 1;
    for (std::size_t k = 0; k + 1 < lines[d].size(); ++k) {
      along[d].push_back(lines[d][k]);
      if (order == 2) along[d].push_back(0.5 * (lines[d][k] + lines[d][k + 1]));
    }
    along[d].push_back(lines[d].back());
  }
  const auto split = [](Index number, const std::array<Index, Dim>& counts) {
    std::array<Index, Dim> places;
    for (std::size_t d = 0; d < Dim; ++d) {
      places[d] = number % counts[d];
      number /= counts[d];
    }
    return places;
  };
  std::array<Index, Dim> node_counts;
  Index node_count = 1;
  Index element_count = 1;
  for (std::size_t d = 0; d < Dim; ++d) {
    node_counts[d] = static_cast<Index>(along[d].size());
    node_count *= node_counts[d];
    element_count *= cells[d];
  }
  std::vector<Vec<Dim>> nodes(static_cast<std::size_t>(node_count));
  for (Index n = 0; n < node_count; ++n) {
    const auto places = split(n, node_counts);
    for (std::size_t d = 0; d < Dim; ++d) nodes[static_cast<std::size_t>(n)][d] = along[d][static_cast<std::size_t>(places[d])];
  }
  const int per_element = whole_power(order + 1, Dim);
  std::vector<Index> elements;
  elements.reserve(static_cast<std::size_t>(element_count * per_element));
  std::map<std::string, std::vector<ElementFace>> parts;
  for (Index e = 0; e < element_count; ++e) {
    const auto cell = split(e, cells);
    for (int local = 0; local < per_element; ++local) {
      const auto places = places_of<Dim>(local, order);
      Index number = 0;
      for (std::size_t d = Dim; d-- > 0;) number = number * node_counts[d] + cell[d] * order + places[d];
      elements.push_back(number);
    }
    for (std::size_t d = 0; d < Dim; ++d) {
      const int axis = static_cast<int>(d);
      if (cell[d] == 0) parts[k_side_names[d][0]].push_back({e, axis, false});
      if (cell[d] == cells[d] - 1) parts[k_side_names[d][1]].push_back({e, axis, true});
    }
  }
  return Mesh<Dim>(order, std::move(nodes), std::move(elements), std::move(parts));
}

std::vector<Real> halved(const std::vector<Real>& line) {
  std::vector<Real> fine;
  fine.reserve(2 * line.size());
  for (std::size_t k = 0; k + 1 < line.size(); ++k) {
    fine.push_back(line[k]);
    fine.push_back(0.5 * (line[k] + line[k + 1]));
  }
  fine.push_back(line.back());
  return fine;
}

std::vector<Real> graded_line(Real lower, Real upper, int cells, Real ratio, int refinements) {
  std::vector<Real> line = {lower};
  // Each line from the sum of a geometric series, so that equal cells (ratio 1) stay equal to the last bit.
  const Real first = ratio == 1 ? (upper - lower) / cells : (upper - lower) * (ratio - 1) / (std::pow(ratio, cells) - 1);
  Real length = first;
  for (int k = 1; k < cells; ++k) {
    line.push_back(ratio == 1 ? lower + first * k : line.back() + length);
    length *= ratio;
  }
  line.push_back(upper);
  for (int r = 0; r < refinements; ++r) line = halved(line);
  return line;
}

template class Mesh<2>;
template class Mesh<3>;
template Mesh<2> tensor_mesh<2>(const std::array<std::vector<Real>, 2>&, int);
template Mesh<3> tensor_mesh<3>(const std::array<std::vector<Real>, 3>&, int);

}  // namespace matpoint
