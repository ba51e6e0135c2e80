// All constitutive laws: a new one adds its header and its name here, and nothing else anywhere. The registry and the tests over all
// laws read this list.
#pragma once

#include <tuple>

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

namespace matpoint {

using AllLaws = std::tuple<StVenantKirchhoff, NeoHookean, NewtonianFluid, Hencky, J2, DruckerPrager, MohrCoulomb, MuI, HerschelBulkley,
                           JohnsonCook, FixedCorotated, Snow, CamClay, MooneyRivlin, Yeoh, Gent, Ogden, Viscoelastic, RankineDamage,
                           IdealGas, StiffenedGas, MieGruneisen, Jwl>;

}  // namespace matpoint
