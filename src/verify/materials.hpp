// What the problems of laws that flow share.
#pragma once

#include "verify/analytic.hpp"

namespace matpoint {

/// A case with nothing numerical but what the text says.
Case default_case(const std::string& name, const std::string& text);
/// Boundaries of a case: sides without friction.
std::string slip_sides(std::initializer_list<const char*> sides);
/// Place on an axis below which a share of the particles of the first body lies [m].
Real quantile(const Simulation& sim, std::size_t axis, Real share);
Real greatest(const Simulation& sim, std::size_t axis);

/// Grains and muds (materials_flows.cpp).
void add_grains(VerifySuite& suite);
void add_flows(VerifySuite& suite);
/// Ground that stands or slides (materials_slopes.cpp).
void add_slopes(VerifySuite& suite);
/// Metal (materials_necking.cpp).
void add_necking(VerifySuite& suite);
/// A thick cylinder (thick_cylinder.cpp).
void add_yielding_cylinder(VerifySuite& suite);
/// Gases, brittle solids and ground at rest (materials_states.cpp).
void add_states(VerifySuite& suite);

}  // namespace matpoint
