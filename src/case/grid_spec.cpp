#include "case/grid_spec.hpp"

#include <algorithm>
#include <cmath>

#include "case/case_reading.hpp"
#include "core/interpolate.hpp"

namespace matpoint {
namespace {

constexpr Real k_nodes_max = 4e9;

void cells_from_size(GridSpec& grid, const Input& input, const ReadContext& context) {
  const auto dim = static_cast<std::size_t>(context.dim);
  const Input& given = at_key(input, "cell_size");
  if (grid.cell_size.size() != 1 && grid.cell_size.size() != dim) {
    fail_input(given, context,
               fmt::format("cell_size = {} has {} numbers; give one, or one per direction ({})", given.text(), grid.cell_size.size(), dim));
  }
  if (grid.cell_size.size() == 1) grid.cell_size.resize(dim, grid.cell_size[0]);
  for (std::size_t d = 0; d < dim; ++d) {
    const Real side = grid.upper[d] - grid.lower[d];
    const Real exact = side / grid.cell_size[d];
    const Real whole = std::round(exact);
    if (whole < 1 || whole > 2e9 || std::abs(exact - whole) > 1e-9 * whole) {
      const Real nearest = side / std::max(Real{1}, whole);
      fail_input(given, context,
                 fmt::format("cell_size = {} does not divide the side of {} m in {} ({} cells); the nearest that does is {:.10g}",
                             grid.cell_size[d], side, "xyz"[d], exact, nearest));
    }
    grid.cells.push_back(static_cast<int>(whole));
  }
}

/// Grading and refinements, which only meshes of the implicit solver have.
void check_mesh(GridSpec& grid, const Input& input, const ReadContext& context) {
  const auto dim = static_cast<std::size_t>(context.dim);
  if (grid.grading.size() == 1) grid.grading.resize(dim, grid.grading[0]);
  if (!grid.grading.empty() && grid.grading.size() != dim) {
    fail_input(at_key(input, "grading"), context,
               fmt::format("grading has {} numbers; give one, or one per direction ({})", grid.grading.size(), dim));
  }
  for (std::size_t d = 0; d < 3; ++d) {
    const std::string key = std::string("lines_") + "xyz"[d];
    const std::vector<Real>& line = grid.lines[d];
    if (line.empty()) continue;
    if (d >= dim) fail_input(at_key(input, key), context, fmt::format("{} is for dim = 3", key));
    if (!grid.grading.empty() && grid.grading[d] != 1)
      fail_input(at_key(input, key), context, fmt::format("{} and grading are both given; give one of them", key));
    if (line.size() != static_cast<std::size_t>(grid.cells[d]) + 1 || line.front() != grid.lower[d] || line.back() != grid.upper[d]) {
      fail_input(at_key(input, key), context,
                 fmt::format("{} must go from lower = {} to upper = {} in {} cells, so with {} numbers; it has {}, from {} to {}", key,
                             grid.lower[d], grid.upper[d], grid.cells[d], grid.cells[d] + 1, line.size(), line.front(), line.back()));
    }
    for (std::size_t k = 1; k < line.size(); ++k) {
      if (line[k] > line[k - 1]) continue;
      fail_input(at_key(input, key), context,
                 fmt::format("{0}[{1}] = {2} must be greater than {0}[{3}] = {4}", key, k, line[k], k - 1, line[k - 1]));
    }
  }
  for (std::size_t d = 0; d < grid.grading.size(); ++d) {
    const Real spread = std::pow(grid.grading[d], grid.cells[d] - 1);
    if (spread < 1e6 && spread > 1e-6) continue;
    fail_input(at_key(input, "grading"), context,
               fmt::format("grading = {} over {} cells makes the last {:.3g} times as long as the first, allowed: 1e-6 to 1e6",
                           grid.grading[d], grid.cells[d], spread));
  }
}

/// The quadrilateral into which the box is mapped.
void check_corners(const GridSpec& grid, const Input& input, const ReadContext& context) {
  if (grid.corners.empty()) return;
  const Input& given = at_key(input, "corners");
  if (context.dim != 2) fail_input(given, context, "corners is for dim = 2");
  if (grid.corners.size() != 4) {
    fail_input(given, context,
               fmt::format("corners has {} points; give 4, counter-clockwise from the lower left: lower left, lower right, upper right, "
                           "upper left",
                           grid.corners.size()));
  }
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec3& x = grid.corners[k];
    for (std::size_t d = 0; d < 2; ++d) {
      if (x[d] >= grid.lower[d] && x[d] <= grid.upper[d]) continue;
      fail_input(given, context,
                 fmt::format("corners[{}] = [{}, {}] is outside of the box from lower = [{}, {}] to upper = [{}, {}]", k, x[0], x[1],
                             grid.lower[0], grid.lower[1], grid.upper[0], grid.upper[1]));
    }
    const Vec3& before = grid.corners[(k + 3) % 4];
    const Vec3& after = grid.corners[(k + 1) % 4];
    const Real area = (x[0] - before[0]) * (after[1] - x[1]) - (x[1] - before[1]) * (after[0] - x[0]);
    if (area > 0) continue;
    fail_input(given, context,
               fmt::format("corners[{}] = [{}, {}]: cells there would be turned inside out; go counter-clockwise from the lower left, with "
                           "angles below 180 degrees",
                           k, x[0], x[1]));
  }
}

/// The ring into which the box is mapped: within the box, for what is outside of that has left the grid.
void check_ring(const GridSpec& grid, const Input& input, const ReadContext& context) {
  if (!grid.ring) return;
  const RingSpec& ring = *grid.ring;
  const Input& given = at_key(input, "ring");
  if (!grid.corners.empty()) fail_input(given, context, "ring and corners are both given; give one of them");
  if (ring.center.size() != 2)
    fail_input(given, context, fmt::format("ring: center has {} numbers; it must have 2, x and y of the axis", ring.center.size()));
  if (!(ring.outer_radius > ring.inner_radius)) {
    fail_input(given, context,
               fmt::format("ring: outer_radius = {} must be greater than inner_radius = {}", ring.outer_radius, ring.inner_radius));
  }
  const Real angle = ring.end_angle - ring.start_angle;
  if (!(angle > 0 && angle < 360)) {
    fail_input(
        given, context,
        fmt::format("ring: start_angle = {} and end_angle = {} make {} degrees, allowed: above 0, below 360 (the ends of a full ring "
                    "would not be joined)",
                    ring.start_angle, ring.end_angle, angle));
  }
  constexpr Real k_widest = 45;  // degrees: between its chords a ring has lost a tenth of its area then
  if (angle / grid.cells[1] > k_widest) {
    fail_input(given, context,
               fmt::format("ring: {} degrees in {} cells make cells of {:.4g} degrees, allowed: {} at the most; give it more cells in y",
                           angle, grid.cells[1], angle / grid.cells[1], k_widest));
  }
  constexpr Real k_tolerance = 1e-9;
  Vec3 least = grid.upper, greatest = grid.lower;
  const auto reach = [&](const Vec3& x) {
    for (std::size_t d = 0; d < 2; ++d) {
      least[d] = std::min(least[d], x[d]);
      greatest[d] = std::max(greatest[d], x[d]);
    }
  };
  for (const Real x : {grid.lower[0], grid.upper[0]}) {
    for (const Real y : {grid.lower[1], grid.upper[1]}) reach(grid.mapped({x, y, 0}));
  }
  for (Real quarter = 90 * std::ceil(ring.start_angle / 90); quarter < ring.end_angle; quarter += 90) {
    const Real share = (quarter - ring.start_angle) / angle;
    reach(grid.mapped({grid.upper[0], grid.lower[1] + share * (grid.upper[1] - grid.lower[1]), 0}));
  }
  for (std::size_t d = 0; d < 2; ++d) {
    const Real margin = k_tolerance * (grid.upper[d] - grid.lower[d]);
    if (least[d] >= grid.lower[d] - margin && greatest[d] <= grid.upper[d] + margin) continue;
    fail_input(
        given, context,
        fmt::format("ring: it reaches from {:.6g} to {:.6g} in {}, outside of the box from lower = {} to upper = {}; enlarge the box",
                    least[d], greatest[d], "xy"[d], grid.lower[d], grid.upper[d]));
  }
}

}  // namespace

Vec3 GridSpec::mapped(const Vec3& x) const {
  const Real a = (x[0] - lower[0]) / (upper[0] - lower[0]);
  const Real b = (x[1] - lower[1]) / (upper[1] - lower[1]);
  Vec3 result = x;
  if (ring) {
    constexpr Real k_degree = 3.14159265358979323846 / 180;
    const Real r = mixed(ring->inner_radius, ring->outer_radius, a);
    const Real angle = mixed(ring->start_angle, ring->end_angle, b);
    // Along the axes to the last bit: a side there is straight.
    const Real quarters = angle / 90;
    const bool is_along = quarters == std::round(quarters);
    const Real cosine = is_along ? std::round(std::cos(angle * k_degree)) : std::cos(angle * k_degree);
    const Real sine = is_along ? std::round(std::sin(angle * k_degree)) : std::sin(angle * k_degree);
    result[0] = ring->center[0] + r * cosine;
    result[1] = ring->center[1] + r * sine;
  } else if (!corners.empty()) {
    for (std::size_t d = 0; d < 2; ++d)
      result[d] = (1 - b) * ((1 - a) * corners[0][d] + a * corners[1][d]) + b * ((1 - a) * corners[3][d] + a * corners[2][d]);
  }
  return result;
}

void check_grid(GridSpec& grid, const Input& input, const ReadContext& context) {
  const auto dim = static_cast<std::size_t>(context.dim);
  for (std::size_t d = 0; d < dim; ++d) {
    if (grid.upper[d] > grid.lower[d]) continue;
    fail_input(at_key(input, "upper"), context,
               fmt::format("upper[{}] = {} must be greater than lower[{}] = {}", d, grid.upper[d], d, grid.lower[d]));
  }
  if (is_given(input, "cells") == is_given(input, "cell_size")) {
    fail_input(input, context,
               is_given(input, "cells") ? "cells and cell_size are both given; give one of them"
                                        : "cells is missing: give cells = [...], or cell_size = ...");
  }
  if (is_given(input, "cells")) {
    if (grid.cells.size() != dim) {
      const Input& given = at_key(input, "cells");
      fail_input(
          given, context,
          fmt::format("cells = {} has {} numbers; the case has dim = {}, so it must have {}", given.text(), grid.cells.size(), dim, dim));
    }
    for (std::size_t d = 0; d < dim; ++d) grid.cell_size.push_back((grid.upper[d] - grid.lower[d]) / grid.cells[d]);
  } else {
    cells_from_size(grid, input, context);
  }
  check_mesh(grid, input, context);
  check_corners(grid, input, context);
  check_ring(grid, input, context);
  Real nodes = 1;
  for (std::size_t d = 0; d < dim; ++d) {
    nodes *= static_cast<Real>(grid.cells[d]) * std::ldexp(1, grid.refinements) + 1;
    const Real size = grid.cell_size[d];
    if (!(size > 0) || !std::isfinite(size) || !std::isfinite(1 / size)) {
      fail_input(input, context,
                 fmt::format("the cells' side of {} m in {} is beyond the range of numbers; lengths are in m", size, "xyz"[d]));
    }
  }
  if (nodes > k_nodes_max)
    fail_input(input, context,
               fmt::format("the grid has {:.3g} nodes, at most {:.0g} are possible; take larger cells", nodes, k_nodes_max));
  if (grid.is_axisymmetric) {
    const Input& given = at_key(input, "axisymmetric");
    if (context.dim != 2) fail_input(given, context, "axisymmetric is for dim = 2, the plane of the radius x and the axis y");
    if (grid.lower[0] < 0)
      fail_input(at_key(input, "lower"), context,
                 fmt::format("lower[0] = {} must be >= 0: with axisymmetric, x is the distance from the axis", grid.lower[0]));
  }
  check_words(grid.periodic, "periodic", axis_names(context.dim), input, context);
}

void RingSpec::declare(ParameterTable<RingSpec>& table) {
  table.optional("center", "m", &RingSpec::center, any_number(), "x and y of its axis.");
  table.required("inner_radius", "m", &RingSpec::inner_radius, positive(), "Radius of the side \"left\".");
  table.required("outer_radius", "m", &RingSpec::outer_radius, positive(), "Radius of the side \"right\".");
  table.optional("start_angle", "degrees", &RingSpec::start_angle, any_number(),
                 "Of the side \"bottom\", from the x axis, counter-clockwise.");
  table.optional("end_angle", "degrees", &RingSpec::end_angle, any_number(), "Of the side \"top\".");
}

void GridSpec::declare(ParameterTable<GridSpec>& table) {
  table.optional("lower", "m", &GridSpec::lower, any_number(), "Corner with the smallest coordinates.");
  table.required("upper", "m", &GridSpec::upper, any_number(), "Corner with the largest coordinates.");
  table.optional("cells", "1", &GridSpec::cells, at_least(1), "Cells per direction; either this or cell_size.");
  table.custom(
      {"cell_size", "m", type_text<std::vector<Real>>(), "", "> 0, divides the sides to 1e-9",
       "Side of a cell, one number or one per direction.", false},
      [](GridSpec& grid, const Input& input, const ReadContext& context) {
        read_value(input, context, "cell_size", positive(), grid.cell_size);
      },
      [](const GridSpec&, int) -> std::optional<Input> { return std::nullopt; });  // written as cells
  table.optional("periodic", "1", &GridSpec::periodic, any_number(), "Directions in which the two sides are one, e.g. [\"x\"].");
  table.custom(
      {"axisymmetric", "1", "true or false", "false", "",
       "2D, explicit solver: x is the distance r from an axis, y the place along it; bodies are rings, with masses, forces and energies of "
       "the "
       "full circle.",
       false},
      [](GridSpec& grid, const Input& input, const ReadContext& context) {
        read_value(input, context, "axisymmetric", any_number(), grid.is_axisymmetric);
      },
      [](const GridSpec& grid, int) -> std::optional<Input> {
        if (!grid.is_axisymmetric) return std::nullopt;
        return Input::boolean(true);
      });
  table.custom(
      {"grading", "1", type_text<std::vector<Real>>(), "1", "> 0",
       "Implicit solver on elements: how many times as long each cell is as the one before it, one number or one per direction.", false},
      [](GridSpec& grid, const Input& input, const ReadContext& context) {
        read_value(input, context, "grading", positive(), grid.grading);
      },
      [](const GridSpec& grid, int dim) -> std::optional<Input> {
        if (grid.grading.empty()) return std::nullopt;
        return write_value(grid.grading, dim);
      });
  for (std::size_t d = 0; d < 3; ++d) {
    const std::string name = std::string("lines_") + "xyz"[d];
    table.custom(
        {name, "m", "array of numbers", "", "ascending, from lower to upper, one more than cells",
         "Implicit solver on elements: where the cells begin and end in this direction, instead of equal or graded ones.", false},
        [=](GridSpec& grid, const Input& input, const ReadContext& context) {
          read_value(input, context, name, any_number(), grid.lines[d]);
        },
        [=](const GridSpec& grid, int dim) -> std::optional<Input> {
          if (grid.lines[d].empty()) return std::nullopt;
          return write_value(grid.lines[d], dim);
        });
  }
  table.custom(
      {"refinements", "1", "integer", "0", "0 <= value <= 12", "Implicit solver: how many times all cells are halved.", false},
      [](GridSpec& grid, const Input& input, const ReadContext& context) {
        read_value(input, context, "refinements", between_closed(0, 12), grid.refinements);
      },
      [](const GridSpec& grid, int) -> std::optional<Input> {
        if (grid.refinements == 0) return std::nullopt;
        return Input::integer(grid.refinements);
      });
  table.custom(
      {"corners", "m", type_text<std::vector<Vec3>>(), "", "4 points within the box, counter-clockwise from the lower left",
       "Implicit solver on elements, 2D: the quadrilateral into which the box is mapped, with all its lines.", false},
      [](GridSpec& grid, const Input& input, const ReadContext& context) {
        read_value(input, context, "corners", any_number(), grid.corners);
      },
      [](const GridSpec& grid, int dim) -> std::optional<Input> {
        if (grid.corners.empty()) return std::nullopt;
        return write_value(grid.corners, dim);
      });
  table.custom(
      {"ring", "1", "table", "", "", "Implicit solver on elements: the sector of a ring into which the box is mapped, with all its lines.",
       false},
      [](GridSpec& grid, const Input& input, const ReadContext& context) {
        if (input.kind() != Input::Kind::table)
          fail_input(input, context,
                     fmt::format("ring must be a table {{ inner_radius = ..., outer_radius = ... }}, got {}", input.text()));
        const ReadContext inside{context.dim, context.where.empty() ? "ring" : context.where + ": ring"};
        parameters_of<RingSpec>().read(input, inside, grid.ring.emplace());
      },
      [](const GridSpec& grid, int dim) -> std::optional<Input> {
        if (!grid.ring) return std::nullopt;
        return parameters_of<RingSpec>().write(*grid.ring, dim);
      });
  table.choice(
      "particles_outside", &GridSpec::particles_outside,
      {{"error", OutsidePolicy::error}, {"remove", OutsidePolicy::remove}, {"stop", OutsidePolicy::stop}},
      "What happens when a particle leaves the grid: the run fails, the particle is removed and booked, or the run ends normally.");
}

}  // namespace matpoint
