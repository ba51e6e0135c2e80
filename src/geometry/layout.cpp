#include "geometry/layout.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "geometry/layered_layouts.hpp"

namespace matpoint {
namespace {

// Ids are 32 bit wide inside the solver; a wrong power of ten shall be said at once and not after an hour of swapping.
constexpr Real k_candidates_max = 4e9;

void require_bounded(const Region& region, int dim) {
  const Vec3 lower = region.lower();
  const Vec3 upper = region.upper();
  for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d) {
    if (std::isfinite(lower[d]) && std::isfinite(upper[d])) continue;
    throw InputError(
        "its region is unbounded, so it cannot be filled with particles; use a bounded region, or cut the half-space out of one with "
        "\"difference\"");
  }
}

void require_countable(Real candidates) {
  if (candidates <= k_candidates_max) return;
  throw InputError("its layout would try {:.3g} places for particles, at most {:.0g} are possible; take a coarser layout", candidates,
                   k_candidates_max);
}

/// The least that a particle takes, so that only what surely does not fit is refused.
constexpr Real k_particle_bytes = 100;

void require_memory(Real particles) {
  const Real memory = static_cast<Real>(sysconf(_SC_PHYS_PAGES)) * static_cast<Real>(sysconf(_SC_PAGESIZE));
  if (particles * k_particle_bytes <= memory) return;
  throw InputError(
      "its layout makes about {:.3g} particles, which do not fit into this machine's memory of {:.3g} GB; take a coarser layout", particles,
      memory / 1e9);
}

/// All particles get the same volume, so that their sum is the body's, where a formula gives that; else the share of their lattice box.
Seeds with_equal_volumes(std::vector<Vec3> positions, const Region& region, int dim, Real box_volume) {
  Seeds seeds;
  const auto n = static_cast<Real>(positions.size());
  const std::optional<Real> measure = region.measure(dim);
  seeds.volume.assign(positions.size(), measure ? *measure / n : box_volume);
  seeds.position = std::move(positions);
  return seeds;
}

/// Calls f(i, j, k) with the first index outermost, k only in 3D.
template <class F>
void for_each_box(int dim, const std::array<Index, 3>& count, F&& f) {
  for (Index i = 0; i < count[0]; ++i) {
    for (Index j = 0; j < count[1]; ++j) {
      for (Index k = 0; k < (dim == 3 ? count[2] : 1); ++k) f(std::array<Index, 3>{i, j, k});
    }
  }
}

/// `value` as one number per direction: one number stands for all. Throws InputError for another length.
std::vector<int> per_direction(const std::vector<int>& value, const std::string& name, const Input& input, const ReadContext& context) {
  const auto dim = static_cast<std::size_t>(context.dim);
  if (value.size() == 1) return std::vector<int>(dim, value[0]);
  if (value.size() != dim) {
    fail_input(input, context,
               fmt::format("{} = {} has {} numbers; give one, or one per direction ({})", name, input.text(), value.size(), dim));
  }
  return value;
}

/// A parameter that takes one integer, or one per direction.
template <class T>
void declare_counts(ParameterTable<T>& table, const std::string& name, std::vector<int> T::*member, const std::string& help) {
  table.custom(
      {name, "1", "integer, or one per direction", "", ">= 1", help, true},
      [=](T& object, const Input& input, const ReadContext& context) {
        std::vector<int> given;
        if (input.is_number()) {
          given.resize(1);
          read_value(input, context, name, at_least(1), given[0]);
        } else {
          read_value(input, context, name, at_least(1), given);
        }
        object.*member = per_direction(given, name, input, context);
      },
      [=](const T& object, int dim) -> std::optional<Input> { return write_value(object.*member, dim); });
}

// --- layouts ---------------------------------------------------------------------------------------------------------

struct Lattice final : Layout {
  static constexpr auto name = "lattice";
  static constexpr auto summary =
      "The region's bounding box cut into divisions[0] x divisions[1] (x divisions[2]) boxes with 1 or 2 points per direction in each; "
      "points "
      "outside of the region are left out.";

  std::vector<int> divisions;
  int points = 1;

  static void declare(ParameterTable<Lattice>& table) {
    declare_counts(table, "divisions", &Lattice::divisions, "Boxes along each side of the region's bounding box.");
    table.optional(
        "points", "1", &Lattice::points, between_closed(1, 2),
        "Points per direction in each box: 1 in its middle, or 2 at the Gauss points, +-1/(2 sqrt 3) of its side from the middle.");
  }
  Seeds fill(const Region* pointer, const SeedingGrid& grid) const override {
    const Region& region = *pointer;
    require_bounded(region, grid.dim);
    const Vec3 lower = region.lower();
    const Vec3 upper = region.upper();
    std::array<Index, 3> count{1, 1, 1};
    std::array<Index, 3> points_along{1, 1, 1};
    Vec3 side{};
    Real box_volume = 1;
    Real candidates = 1;
    for (std::size_t d = 0; d < static_cast<std::size_t>(grid.dim); ++d) {
      count[d] = divisions[d];
      points_along[d] = points;
      side[d] = (upper[d] - lower[d]) / static_cast<Real>(count[d]);
      box_volume *= side[d] / points;
      candidates *= static_cast<Real>(count[d]) * points;
    }
    require_countable(candidates);
    require_memory(region.measure(grid.dim).value_or(0) / box_volume);
    const Real offset = points == 2 ? 1 / (2 * std::sqrt(Real{3})) : 0;
    std::vector<Vec3> positions;
    for_each_box(grid.dim, count, [&](const std::array<Index, 3>& box) {
      for_each_box(grid.dim, points_along, [&](const std::array<Index, 3>& point) {
        Vec3 x{};
        for (std::size_t d = 0; d < static_cast<std::size_t>(grid.dim); ++d) {
          x[d] = lower[d] + (static_cast<Real>(box[d]) + 0.5 + (point[d] == 0 ? -offset : offset)) * side[d];
        }
        if (region.contains(x)) positions.push_back(x);
      });
    });
    Seeds seeds = with_equal_volumes(std::move(positions), region, grid.dim, box_volume);
    for (Real& x : side) x /= points;
    seeds.lattice = {lower, side};
    return seeds;
  }
  Input write(int dim) const override { return write_typed(*this, dim); }
};

struct PerCell final : Layout {
  static constexpr auto name = "per_cell";
  static constexpr auto summary = "So many particles in each cell of the grid, evenly spaced; those outside of the region are left out.";

  std::vector<int> count;
  std::vector<int> along;  ///< Particles per direction in a cell.

  static void declare(ParameterTable<PerCell>& table) {
    table.custom(
        {"count", "1", "integer, or one per direction", "", "a square (2D) or cube (3D) number, or one number per direction, each >= 1",
         "Particles in a cell: 4 in 2D are 2 x 2; [2, 3] are 2 along x and 3 along y.", true},
        [](PerCell& layout, const Input& input, const ReadContext& context) {
          if (input.is_number()) {
            layout.count.resize(1);
            read_value(input, context, "count", at_least(1), layout.count[0]);
            const Index root = std::lround(std::pow(layout.count[0], 1.0 / context.dim));
            const Index power = context.dim == 2 ? root * root : root * root * root;
            if (power != layout.count[0]) {
              fail_input(
                  input, context,
                  fmt::format(
                      "count = {} is no {} number, so it cannot be spread evenly; the nearest is {}, or give one number per direction",
                      layout.count[0], context.dim == 2 ? "square" : "cube", power));
            }
            layout.along.assign(static_cast<std::size_t>(context.dim), static_cast<int>(root));
          } else {
            read_value(input, context, "count", at_least(1), layout.count);
            layout.along = per_direction(layout.count, "count", input, context);
          }
        },
        [](const PerCell& layout, int dim) -> std::optional<Input> { return write_value(layout.along, dim); });
  }
  Seeds fill(const Region* pointer, const SeedingGrid& grid) const override {
    const Region& region = *pointer;
    require_bounded(region, grid.dim);
    const Vec3 lower = region.lower();
    const Vec3 upper = region.upper();
    std::array<Index, 3> first{};
    std::array<Index, 3> number{1, 1, 1};
    Vec3 spacing{};
    Real box_volume = 1;
    Real candidates = 1;
    for (std::size_t d = 0; d < static_cast<std::size_t>(grid.dim); ++d) {
      spacing[d] = grid.cell_size[d] / along[d];
      box_volume *= spacing[d];
      const Real begin = std::floor((lower[d] - grid.lower[d]) / spacing[d]) - 1;
      const Real end = std::ceil((upper[d] - grid.lower[d]) / spacing[d]) + 1;
      candidates *= end - begin;
      require_countable(candidates);
      // Counted from the grid's corner: beyond 2^53 neighbouring places would fall together.
      if (std::max(std::abs(begin), std::abs(end)) > 9e15) throw InputError("its region is too far away from the grid; move it");
      first[d] = static_cast<Index>(begin);
      number[d] = static_cast<Index>(end - begin);
    }
    require_memory(region.measure(grid.dim).value_or(0) / box_volume);
    std::vector<Vec3> positions;
    for_each_box(grid.dim, number, [&](const std::array<Index, 3>& box) {
      Vec3 x{};
      for (std::size_t d = 0; d < static_cast<std::size_t>(grid.dim); ++d) {
        x[d] = grid.lower[d] + (static_cast<Real>(first[d] + box[d]) + 0.5) * spacing[d];
      }
      if (region.contains(x)) positions.push_back(x);
    });
    Seeds seeds = with_equal_volumes(std::move(positions), region, grid.dim, box_volume);
    seeds.lattice = {grid.lower, spacing};
    return seeds;
  }
  Input write(int dim) const override { return write_typed(*this, dim); }
};

struct Polar final : Layout {
  static constexpr auto name = "polar";
  static constexpr auto summary = "Rings of particles about the center of a disk, 2D only; each particle stands for its piece of the ring.";

  int rings = 1;
  std::optional<int> sectors;

  static void declare(ParameterTable<Polar>& table) {
    table.required("rings", "1", &Polar::rings, between_closed(1, 100000), "Rings of equal width.");
    table.optional("sectors", "1", &Polar::sectors, between_closed(3, 1000000),
                   "Particles in each ring; without it as many as make the pieces about square.");
  }
  int count_in(int ring) const { return sectors.value_or(static_cast<int>(std::lround(2 * std::numbers::pi * (ring + 0.5)))); }
  Seeds fill(const Region* pointer, const SeedingGrid& grid) const override {
    const Region& region = *pointer;
    const auto* disk = dynamic_cast<const Disk*>(&region);
    if (disk == nullptr || grid.dim != 2) {
      throw InputError("layout type = \"polar\" fills disks only; use \"lattice\" or \"per_cell\" for other regions");
    }
    Real candidates = 0;
    for (int ring = 0; ring < rings; ++ring) candidates += count_in(ring);
    require_countable(candidates);
    require_memory(candidates);
    Seeds seeds;
    const Real width = disk->radius / rings;
    for (int ring = 0; ring < rings; ++ring) {
      const Real inner = ring * width;
      const Real outer = (ring + 1) * width;
      const int count = count_in(ring);
      const Real half_angle = std::numbers::pi / count;
      // The centre of mass of a piece of a ring, so that the body's first moments are exact.
      const Real radius =
          2.0 / 3 * (std::pow(outer, 3) - std::pow(inner, 3)) / (outer * outer - inner * inner) * std::sin(half_angle) / half_angle;
      for (int k = 0; k < count; ++k) {
        const Real angle = (2 * k + 1) * half_angle;
        seeds.position.push_back({disk->center[0] + radius * std::cos(angle), disk->center[1] + radius * std::sin(angle), 0});
        seeds.volume.push_back(half_angle * (outer * outer - inner * inner));
      }
    }
    return seeds;
  }
  Input write(int dim) const override { return write_typed(*this, dim); }
};

/// Particles one by one.
struct Points final : Layout {
  static constexpr auto name = "points";
  static constexpr auto summary = "Particles where they are given, each with its volume; the body then has no region.";

  std::vector<Vec3> positions;
  std::vector<Real> volumes;

  static void declare(ParameterTable<Points>& table) {
    table.required("positions", "m", &Points::positions, any_number(), "Positions of the particles, dim numbers each.");
    table.required("volumes", "m^3", &Points::volumes, positive(),
                   "Reference volumes (areas in 2D): one number for all particles, or one for each.");
  }
  bool needs_region() const override { return false; }
  Seeds fill(const Region*, const SeedingGrid&) const override {
    Seeds seeds;
    seeds.position = positions;
    seeds.volume = volumes.size() == 1 ? std::vector<Real>(positions.size(), volumes[0]) : volumes;
    return seeds;
  }
  Input write(int dim) const override { return write_typed(*this, dim); }
  void check(const Input& input, const ReadContext& context) const override {
    if (positions.empty()) fail_input(*input.find("positions"), context, "positions is empty; give at least one particle");
    if (volumes.size() == 1 || volumes.size() == positions.size()) return;
    fail_input(*input.find("volumes"), context,
               fmt::format("volumes has {} numbers for {} positions; give one for all, or one for each", volumes.size(), positions.size()));
  }
};

}  // namespace

std::shared_ptr<Layout> points_layout(std::vector<Vec3> positions, std::vector<Real> volumes) {
  auto points = std::make_shared<Points>();
  points->positions = std::move(positions);
  points->volumes = std::move(volumes);
  Input places = Input::table();
  places.set("positions", Input::array());
  places.set("volumes", Input::array());
  points->check(places, {});
  for (const Real volume : points->volumes) {
    if (!(volume > 0) || !std::isfinite(volume)) throw InputError("volumes: {} is not allowed, it must be > 0", volume);
  }
  return points;
}

const TypeRegistry<Layout>& layout_registry() {
  static const TypeRegistry<Layout> registry = [] {
    TypeRegistry<Layout> all;
    all.add<PerCell>();
    all.add<Lattice>();
    all.add<Polar>();
    all.add<Points>();
    add_layered_layouts(all);
    return all;
  }();
  return registry;
}

}  // namespace matpoint
