// What soils and grains share: strength in degrees and pascals, and the checks of it.
#pragma once

#include <optional>

#include "material/flow_law.hpp"

namespace matpoint {

/// Cohesion, friction and dilatancy. Stresses of Kirchhoff's tau.
template <class Law>
struct GranularLaw : PartingLaw<Law> {
  Real cohesion = 0;                   ///< c [Pa]
  Real friction_angle = 0;             ///< phi [deg]
  Real dilatancy_angle = 0;            ///< psi [deg]
  std::optional<Real> tension_cutoff;  ///< Greatest mean stress [Pa]; without it that of the cone's apex.

  static void declare_strength(ParameterTable<Law>& table) {
    PartingLaw<Law>::declare_elastic(table);
    table.required("cohesion", "Pa", static_cast<Real Law::*>(&Law::cohesion), non_negative(),
                   "Shear strength without pressure; 0 for dry sand.");
    table.required("friction_angle", "deg", static_cast<Real Law::*>(&Law::friction_angle),
                   Constraint{"in the interval [0, 60)", [](Real x) { return x >= 0 && x < 60; }}, "Angle of internal friction.");
    table.optional("dilatancy_angle", "deg", static_cast<Real Law::*>(&Law::dilatancy_angle),
                   Constraint{"in the interval [0, friction_angle]", [](Real x) { return x >= 0 && x < 60; }},
                   "0: what flows keeps its volume. More than that dilates for ever, and under a fixed volume builds up pressure.");
    table.optional("tension_cutoff", "Pa", static_cast<std::optional<Real> Law::*>(&Law::tension_cutoff), non_negative(),
                   "Greatest tension, as a mean stress, at which the material parts; default: where the strength of the cone ends.");
  }
  void check(const Input& input, const ReadContext& context) const {
    if (dilatancy_angle > friction_angle) {
      fail_input(input, context,
                 fmt::format("dilatancy_angle = {} is above friction_angle = {}: it would make energy; allowed: 0 to friction_angle",
                             dilatancy_angle, friction_angle));
    }
  }

 protected:
  static Real radians(Real degrees) { return degrees * (3.14159265358979323846 / 180); }
  /// For a cone without an apex [Pa].
  Real no_limit() const { return 1e6 * this->youngs_modulus; }
};

}  // namespace matpoint
