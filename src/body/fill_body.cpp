#include "body/fill_body.hpp"

#include "core/error.hpp"

namespace matpoint {

Seeds fill_body(const BodySpec& body, const SeedingGrid& grid) {
  const std::string where = place_of(body);
  Seeds seeds;
  try {
    seeds = body.layout->fill(body.region.get(), grid);
  } catch (const InputError& error) {
    throw InputError("{}: {}", where, error.what());
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

}  // namespace matpoint
