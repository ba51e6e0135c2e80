// The particles of a body as its description says.
#pragma once

#include "case/body_spec.hpp"
#include "geometry/layout.hpp"
#include "material/initial_state.hpp"

namespace matpoint {

/// The particles of a body. Throws InputError for an empty body and for particles outside of the grid.
Seeds fill_body(const BodySpec& body, const SeedingGrid& grid);

/// The states of a body that starts with a stress, one a particle; none without. Volumes become those without the stress, so that the body
/// fills its region with it.
std::vector<InitialState> initial_states(const BodySpec& body, int dim, Seeds& seeds);

/// The states under the given stresses [Pa], 6 numbers a particle. Throws InputError.
std::vector<InitialState> states_under(const std::string& body, const Material& material, int dim, const std::vector<Real>& stresses);

}  // namespace matpoint
