// The particles of a body as its description says.
#pragma once

#include "case/body_spec.hpp"
#include "geometry/layout.hpp"
#include "grid/grid.hpp"
#include "material/initial_state.hpp"

namespace matpoint {

/// What layouts see of a grid.
template <int Dim, class R>
SeedingGrid seeding_grid(const Grid<Dim, R>& grid, bool has_axis) {
  const GridGeometry geometry = grid.geometry();
  SeedingGrid box{Dim, geometry.lower, {}, geometry.cell_size, has_axis};
  for (int d = 0; d < Dim; ++d) box.upper[static_cast<std::size_t>(d)] = grid.upper(d);
  return box;
}

/// The particles of a body. Throws InputError for an empty body and for particles outside of the grid.
Seeds fill_body(const BodySpec& body, const SeedingGrid& grid);

/// The states of a body that starts with a stress, one a particle; none without. Volumes become those without the stress, so that the body
/// fills its region with it.
std::vector<InitialState> initial_states(const BodySpec& body, int dim, Seeds& seeds);

/// The states under the given stresses [Pa], 6 numbers a particle. Throws InputError.
std::vector<InitialState> states_under(const std::string& body, const Material& material, int dim, const std::vector<Real>& stresses);

}  // namespace matpoint
