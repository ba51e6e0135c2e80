// The everyday problems: what a newcomer writes first, with nothing numerical given.
#pragma once

#include "verify/analytic.hpp"

namespace matpoint {

/// The numerics that a problem is run with: nothing, a quality, or what was asked for.
struct EverydaySetting {
  std::string name;  ///< The end of its rows' names.
  Sets sets;
};

struct EverydayProblem {
  std::string name;
  std::function<Measured(const EverydaySetting&)> run;
  /// For double or single precision.
  std::function<std::vector<VerifyRow>(bool is_single)> rows;
  double cost = 0;
  bool is_quick = true;
};

std::vector<EverydayProblem> everyday_motion();
std::vector<EverydayProblem> everyday_walls();
std::vector<EverydayProblem> everyday_solids();
std::vector<EverydayProblem> everyday_fluids();
std::vector<EverydayProblem> everyday_frames();

/// A case from TOML text with a setting, and changes of what is not numerical.
Case everyday_case(const std::string& text, const EverydaySetting& setting, Sets sets = {});

/// Total energy less the work of what moves from outside [J].
Real total_energy(const Simulation& sim);
/// Runs, and sees that energy after every step over the one at the start.
Range run_with_energy(Simulation& sim);

/// Of the same problem on more cells, in 3D or for longer: a prefix for all names.
Measured with_prefix(const std::string& prefix, const Measured& measured);

/// Groups of particles that are nearer to each other than `distance` [m]: 1 for a body in one piece.
int pieces(const Simulation& sim, std::size_t body, Real distance);

inline const char* const k_fe = "explicit finite elements";
inline const char* const k_everyday_solid =
    "material = { type = \"neo_hookean\", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }\n";
inline const char* const k_everyday_water = "material = { type = \"newtonian_fluid\", density = 1000, pressure_scale = 57142.857 }\n";

}  // namespace matpoint
