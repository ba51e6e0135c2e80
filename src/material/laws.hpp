// All constitutive laws: a new one adds its header and its name here, and nothing else anywhere; or it stays outside of the tree, and CMake
// is given its header (MATPOINT_EXTRA_LAWS). The registry and the tests over all laws read this list.
#pragma once

#include <tuple>
#include <utility>

#include "material/cam_clay.hpp"
#include "material/drucker_prager.hpp"
#include "material/fixed_corotated.hpp"
#include "material/gent.hpp"
#include "material/hencky.hpp"
#include "material/herschel_bulkley.hpp"
#include "material/ideal_gas.hpp"
#include "material/j2.hpp"
#include "material/johnson_cook.hpp"
#include "material/jwl.hpp"
#include "material/mie_gruneisen.hpp"
#include "material/mohr_coulomb.hpp"
#include "material/mooney_rivlin.hpp"
#include "material/mu_i.hpp"
#include "material/neo_hookean.hpp"
#include "material/newtonian_fluid.hpp"
#include "material/ogden.hpp"
#include "material/rankine_damage.hpp"
#include "material/snow.hpp"
#include "material/st_venant_kirchhoff.hpp"
#include "material/stiffened_gas.hpp"
#include "material/viscoelastic.hpp"
#include "material/yeoh.hpp"
#if __has_include("extra_laws.hpp")  // which CMake makes
#include "extra_laws.hpp"
#else
namespace matpoint {
using ExtraLaws = std::tuple<>;
}
#endif

namespace matpoint {

using ShippedLaws = std::tuple<StVenantKirchhoff, NeoHookean, NewtonianFluid, Hencky, J2, DruckerPrager, MohrCoulomb, MuI, HerschelBulkley,
                               JohnsonCook, FixedCorotated, Snow, CamClay, MooneyRivlin, Yeoh, Gent, Ogden, Viscoelastic, RankineDamage,
                               IdealGas, StiffenedGas, MieGruneisen, Jwl>;
using AllLaws = decltype(std::tuple_cat(std::declval<ShippedLaws>(), std::declval<ExtraLaws>()));

}  // namespace matpoint
