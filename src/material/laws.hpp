// All constitutive laws: a new one adds its header and its name here, and nothing else anywhere. The registry and the tests over all
// laws read this list.
#pragma once

#include <tuple>

#include "material/neo_hookean.hpp"
#include "material/newtonian_fluid.hpp"
#include "material/st_venant_kirchhoff.hpp"

namespace matpoint {

using AllLaws = std::tuple<StVenantKirchhoff, NeoHookean, NewtonianFluid>;

}  // namespace matpoint
