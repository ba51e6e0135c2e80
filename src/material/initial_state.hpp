// The state in which a material carries a given stress.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "material/material.hpp"

namespace matpoint {

/// Where a material starts that carries a stress. A law that remembers its strain has it there, and F counts from that; others have it in
/// F.
struct InitialState {
  Material::Matrix F{1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::vector<Real> history;
};

/// The state of the Cauchy stress `sigma` [Pa], xx yy zz xy yz xz: brought there elastically. In plane strain a law that has it in F has
/// the stress zz that follows from the others, and a fluid the mean of all. Throws SolverError where the law cannot carry it.
InitialState initial_state(const Material& material, int dim, const std::array<Real, 6>& sigma, std::optional<Real> overconsolidation);

/// How far the stress of a state moves when nothing moves, relative to its size: 0 within the yield surface.
Real yields_by(const Material& material, int dim, const InitialState& state);

}  // namespace matpoint
