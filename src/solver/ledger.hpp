// The books of energy and momentum.
#pragma once

#include <vector>

#include "core/state.hpp"
#include "core/types.hpp"

namespace matpoint {

/// What one boundary has done.
struct BoundaryShare {
  Vec3 impulse{};  ///< [N s]
  Real work = 0;   ///< [J]
};

/// What crossed the system's border since the start: with it the energy and momentum balances close (docs/theory.md).
struct Ledger {
  Real damping_dissipation = 0;  ///< [J]
  Real viscous_dissipation = 0;  ///< [J]
  Real plastic_dissipation = 0;  ///< Of laws that flow [J].
  Real contact_dissipation = 0;  ///< Taken by the impulses of contact between bodies, and by friction [J].
  Real contact_energy = 0;       ///< Stored now in the forces between pairs of particles [J].
  Real boundary_work = 0;        ///< Work done by moving boundaries on the particles [J].
  Real filter_dissipation = 0;   ///< Taken from fluids: motion of their particles that the grid does not see [J].
  Real shift_work = 0;           ///< Work of moving a fluid's particles apart against gravity [J].
  Vec3 boundary_impulse{};       ///< [N s]
  Vec3 damping_impulse{};        ///< [N s]
  Vec3 gravity_impulse{};        ///< [N s]
  Real body_force_work = 0;      ///< Work done by a body force other than gravity [J].
  Vec3 body_force_impulse{};     ///< [N s]
  Vec3 cutoff_impulse{};         ///< What nodes under the mass cutoff did not pass on [N s].
  Index returned_count = 0;      ///< How often a particle was put back that had passed a closed side.
  Index removed_count = 0;       ///< Particles removed because they left the grid.
  Real removed_mass = 0;         ///< [kg]
  Vec3 removed_momentum{};       ///< [N s]
  Real removed_energy = 0;       ///< Kinetic + strain + gravitational energy of the removed particles [J].
  Real soft_dissipation = 0;     ///< Taken by the implicit solver's soft stiffness [J].
  Real receding_work = 0;        ///< Brought in by its correction for receding particles [J].
  Real integrator_loss = 0;      ///< Taken from the kinetic energy by Newmark's formulas [J]; 0 for beta = 1/4, gamma = 1/2.
  Real reset_loss = 0;           ///< Taken by resets of the background: forces that balanced on the old one do not on the new one [J].

  void declare_state(State& state) {
    state.add("damping_dissipation", damping_dissipation);
    state.add("viscous_dissipation", viscous_dissipation);
    state.add("plastic_dissipation", plastic_dissipation);
    state.add("contact_dissipation", contact_dissipation);
    state.add("contact_energy", contact_energy);
    state.add("boundary_work", boundary_work);
    state.add("filter_dissipation", filter_dissipation);
    state.add("shift_work", shift_work);
    state.add("boundary_impulse", boundary_impulse);
    state.add("damping_impulse", damping_impulse);
    state.add("gravity_impulse", gravity_impulse);
    state.add("body_force_work", body_force_work);
    state.add("body_force_impulse", body_force_impulse);
    state.add("cutoff_impulse", cutoff_impulse);
    state.add("returned_count", returned_count);
    state.add("removed_count", removed_count);
    state.add("removed_mass", removed_mass);
    state.add("removed_momentum", removed_momentum);
    state.add("removed_energy", removed_energy);
    state.add("soft_dissipation", soft_dissipation);
    state.add("receding_work", receding_work);
    state.add("integrator_loss", integrator_loss);
    state.add("reset_loss", reset_loss);
  }

  /// Of single boundaries, in the order of the case: a part of boundary_impulse and boundary_work, which the explicit solver takes out
  /// after each step.
  std::vector<BoundaryShare> boundaries;

  /// Books what the boundary `condition` does along an axis.
  void press(int condition, std::size_t axis, Real impulse, Real work) {
    boundary_impulse[axis] += impulse;
    boundary_work += work;
    if (condition < 0) return;
    const auto c = static_cast<std::size_t>(condition);
    if (c >= boundaries.size()) boundaries.resize(c + 1);
    boundaries[c].impulse[axis] += impulse;
    boundaries[c].work += work;
  }
  /// Adds what the boundaries did in the books of a part.
  void add_boundaries(const Ledger& part) {
    boundary_work += part.boundary_work;
    for (std::size_t d = 0; d < 3; ++d) boundary_impulse[d] += part.boundary_impulse[d];
    if (boundaries.size() < part.boundaries.size()) boundaries.resize(part.boundaries.size());
    for (std::size_t c = 0; c < part.boundaries.size(); ++c) {
      for (std::size_t d = 0; d < 3; ++d) boundaries[c].impulse[d] += part.boundaries[c].impulse[d];
      boundaries[c].work += part.boundaries[c].work;
    }
  }

  /// What the bodies have lost of their energy by all of this, or keep between them [J].
  Real energy_spent() const {
    return damping_dissipation + viscous_dissipation + plastic_dissipation + contact_dissipation + contact_energy - boundary_work -
           body_force_work + filter_dissipation - shift_work + removed_energy + soft_dissipation - receding_work + integrator_loss +
           reset_loss;
  }
};

}  // namespace matpoint
