#include "body/fill_body.hpp"

#include <map>

#include "core/error.hpp"
#include "core/tensor.hpp"

namespace matpoint {

Seeds fill_body(const BodySpec& body, const SeedingGrid& grid) {
  const std::string where = place_of(body);
  Seeds seeds;
  try {
    seeds = body.layout->fill(body.region.get(), grid);
  } catch (const InputError& error) {
    throw InputError("{}: {}", where, error.what());
  }
  // The other half of a region. Points that a case names are left to the check below.
  if (grid.has_axis && body.region) {
    std::size_t kept = 0;
    for (std::size_t p = 0; p < seeds.position.size(); ++p) {
      if (seeds.position[p][0] < 0) continue;
      seeds.position[kept] = seeds.position[p];
      seeds.volume[kept++] = seeds.volume[p];
    }
    seeds.position.resize(kept);
    seeds.volume.resize(kept);
  }
  const std::size_t n = seeds.position.size();
  if (n == 0) throw InputError("{}: no particle lies in its region; make the region larger or the layout finer", where);
  if (n > 0x7ffffff0u) throw InputError("{}: {} particles are more than 2^31", where, n);
  const auto point = [&](const Vec3& x) { return fmt::format("[{}]", fmt::join(x.begin(), x.begin() + grid.dim, ", ")); };
  for (std::size_t p = 0; p < n; ++p) {
    for (std::size_t d = 0; d < static_cast<std::size_t>(grid.dim); ++d) {
      if (seeds.position[p][d] >= grid.lower[d] && seeds.position[p][d] <= grid.upper[d]) continue;
      throw InputError("{}: particle {} at {} is outside the grid {} to {}; move the body or enlarge the grid", where, p,
                       point(seeds.position[p]), point(grid.lower), point(grid.upper));
    }
  }
  return seeds;
}

std::vector<InitialState> initial_states(const BodySpec& body, int dim, Seeds& seeds) {
  std::vector<InitialState> states;
  if (!body.initial_stress) return states;
  // Whole rows of particles have the same stress.
  std::map<std::array<Real, 6>, std::size_t> known;
  for (std::size_t p = 0; p < seeds.position.size(); ++p) {
    const std::array<Real, 6> stress = body.initial_stress->at(seeds.position[p]);
    const auto [at, is_new] = known.emplace(stress, p);
    try {
      if (is_new)
        states.push_back(initial_state(*body.material, dim, stress, body.initial_stress->overconsolidation));
      else
        states.push_back(states[at->second]);
    } catch (const SolverError& error) {
      throw InputError("{}: initial_stress: {}", place_of(body), error.what());
    }
    if (!body.material->remembers_strain()) {
      const Material::Matrix& F = states.back().F;
      seeds.volume[p] /= determinant(Mat3<Real>{{F[0], F[1], F[2], F[3], F[4], F[5], F[6], F[7], F[8]}});
    }
  }
  return states;
}

std::vector<InitialState> states_under(const std::string& body, const Material& material, int dim, const std::vector<Real>& stresses) {
  std::vector<InitialState> states;
  for (std::size_t p = 0; 6 * p < stresses.size(); ++p) {
    std::array<Real, 6> stress;
    std::copy_n(stresses.begin() + static_cast<std::ptrdiff_t>(6 * p), 6, stress.begin());
    try {
      states.push_back(initial_state(material, dim, stress, std::nullopt));
    } catch (const SolverError& error) {
      throw InputError("body \"{}\": stress of particle row {}: {}", body, p, error.what());
    }
  }
  return states;
}

}  // namespace matpoint
