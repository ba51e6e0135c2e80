#include "run/risks.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.hpp"

namespace matpoint {
namespace {

using Cell = std::array<Index, 3>;

/// Per cell of the grid, for each body.
using CellMap = std::map<Cell, std::vector<Real>>;

/// The volume [m^dim] that the particles of each body have in the cells, and how many they are there.
struct Filling {
  CellMap volume;
  CellMap count;
};

Filling filling_of(const Solver& solver) {
  Filling filling;
  const auto dim = static_cast<std::size_t>(solver.dim());
  const GridGeometry& grid = solver.grid();
  for (std::size_t b = 0; b < solver.body_count(); ++b) {
    const std::vector<Real> x = solver.field(b, "position").values;
    const std::vector<Real> volume = solver.field(b, "volume").values;
    for (std::size_t p = 0; p < volume.size(); ++p) {
      Cell cell{};
      for (std::size_t d = 0; d < dim; ++d) cell[d] = static_cast<Index>(std::floor((x[p * dim + d] - grid.lower[d]) / grid.cell_size[d]));
      for (const auto& [map, value] : {std::pair(&filling.volume, volume[p]), std::pair(&filling.count, Real{1})}) {
        std::vector<Real>& of_bodies = (*map)[cell];
        of_bodies.resize(solver.body_count());
        of_bodies[b] += value;
      }
    }
  }
  return filling;
}

Real cell_volume(const Solver& solver) {
  Real volume = 1;
  for (std::size_t d = 0; d < static_cast<std::size_t>(solver.dim()); ++d) volume *= solver.grid().cell_size[d];
  return volume;
}

/// Two bodies in one place. Bodies that only touch share cells that are full; a layout may overfill those by a little.
void find_overlaps(const Solver& solver, const Filling& filling, std::vector<std::string>& risks) {
  constexpr Real k_overfull = 1.25;  // of a cell
  constexpr Real k_share = 0.01;     // of the smaller body's volume
  const std::size_t bodies = solver.body_count();
  const Real cell = cell_volume(solver);
  for (std::size_t a = 0; a < bodies; ++a) {
    for (std::size_t b = a + 1; b < bodies; ++b) {
      Real in_both = 0, all_a = 0, all_b = 0;
      for (const auto& [place, volume] : filling.volume) {
        all_a += volume[a];
        all_b += volume[b];
        if (volume[a] > 0 && volume[b] > 0 && volume[a] + volume[b] > k_overfull * cell) in_both += volume[a] + volume[b] - cell;
      }
      if (in_both <= k_share * std::min(all_a, all_b)) continue;
      risks.push_back(
          fmt::format("bodies \"{}\" and \"{}\" overlap at the start: {:.2g} {} are filled by both; the same place cannot hold two bodies, "
                      "move one or cut its region with \"difference\"",
                      solver.body_name(a), solver.body_name(b), in_both, solver.dim() == 2 ? "m^2" : "m^3"));
    }
  }
}

/// Linear shapes with one particle in most cells: gaps open between particles, and stresses jump when one changes its cell.
void find_sparse_bodies(const Case& problem, const Solver& solver, const Filling& filling, std::vector<std::string>& risks) {
  constexpr Real k_sparse = 1.5;  // particles per cell
  if (problem.solver.shape != ShapeKind::linear) return;
  for (std::size_t b = 0; b < solver.body_count(); ++b) {
    if (problem.bodies[b].formulation == Formulation::total) continue;
    Real particles = 0, cells = 0;
    for (const auto& [place, count] : filling.count) {
      particles += count[b];
      cells += count[b] > 0 ? 1 : 0;
    }
    constexpr Real k_few = 4;  // a single particle, or a handful, is no continuum
    if (particles <= k_few || particles >= k_sparse * cells) continue;
    risks.push_back(fmt::format(
        "body \"{}\" has {:.2g} particle{} in a cell, too few for shape = \"linear\": it may come apart and gain energy; give it {} "
        "(layout count), or take shape = \"bspline2\"",
        solver.body_name(b), particles / cells, particles > cells ? "s" : "", solver.dim() == 2 ? 4 : 8));
  }
}

/// A node with next to no mass, as linear shapes have where a body has just reached a cell, is thrown by any force: its velocity is
/// harmless to the particle that it weighs next to nothing for, but not its share of the velocity gradient.
void find_unsafe_schemes(const Case& problem, const Solver& solver, std::vector<std::string>& risks) {
  const SolverSpec& scheme = problem.solver;
  const bool all_total = std::all_of(problem.bodies.begin(), problem.bodies.end(),
                                     [](const BodySpec& body) { return body.formulation == Formulation::total; });
  constexpr Real k_careful = 0.1;  // of the stable step: the published examples with USL take steps as short as that
  const bool is_careful = problem.time.dt && *problem.time.dt <= k_careful * solver.stable_dt();
  if (scheme.shape == ShapeKind::linear && !all_total && !is_careful) {
    if (scheme.transfer == Transfer::apic || scheme.transfer == Transfer::tpic) {
      risks.push_back(
          fmt::format("transfer = \"{}\" with shape = \"linear\" is unstable where a node has next to no mass; take shape = \"bspline2\", "
                      "or transfer = "
                      "\"flip\"",
                      scheme.transfer == Transfer::apic ? "apic" : "tpic"));
    } else if (scheme.stress_order == StressOrder::usl) {
      risks.push_back(
          "stress_order = \"usl\" with shape = \"linear\" is unstable where a node has next to no mass; take stress_order = \"usf\" or "
          "\"musl\", or shape = \"bspline2\"");
    }
  }
  if (scheme.stress_order == StressOrder::musl && scheme.damping > 0) {
    risks.push_back(fmt::format(
        "stress_order = \"musl\" with damping drifts away from the state of rest; use stress_order = \"{}\" for damped problems",
        scheme.shape == ShapeKind::linear ? "usf" : "usl"));
  }
}

}  // namespace

std::vector<std::string> risks_of(const Case& problem, const Solver& solver) {
  std::vector<std::string> risks;
  if (problem.is_implicit()) return risks;
  const Filling filling = filling_of(solver);
  find_overlaps(solver, filling, risks);
  find_sparse_bodies(problem, solver, filling, risks);
  find_unsafe_schemes(problem, solver, risks);
  return risks;
}

}  // namespace matpoint
