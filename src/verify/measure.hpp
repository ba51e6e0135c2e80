// What the problems of `matpoint verify` measure on a simulation.
#pragma once

#include "case/case_file.hpp"
#include "run/simulation.hpp"

namespace matpoint {

using Sets = std::vector<std::string>;

/// A case from TOML text, with --set changes.
Case case_from_text(const std::string& name, const std::string& text, const Sets& sets = {});

/// Sums over all bodies: kinetic + strain + gravitational energy [J], the first of them, and momentum [N s].
Real energy(const Simulation& sim);
Real kinetic_energy(const Simulation& sim);
Vec3 momentum(const Simulation& sim);

/// What the scheme lost (+) or made (-) [J]: E0 - E - dissipated + work of boundaries - energy of removed particles.
Real transfer_loss(const Simulation& sim);

/// P - P0 - all booked impulses + removed momentum, the component of greatest magnitude [N s].
Real momentum_remainder(const Simulation& sim);

/// Component c of all particles of a body, by id; stored as xx yy zz xy yz xz for "stress".
std::vector<Real> component(const Simulation& sim, std::size_t body, const std::string& name, std::size_t c);

using Observer = std::function<void(const Simulation&)>;

/// Calls f after every `steps` steps.
void every(Simulation& sim, Index steps, Observer f);

/// Calls f once, at the step nearest to t [s]; for fixed time steps.
void at(Simulation& sim, Real t, Observer f);

/// How many steps make about t [s], at least one; for fixed time steps.
Index steps_in(const Simulation& sim, Real t);

}  // namespace matpoint
