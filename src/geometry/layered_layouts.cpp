#include "geometry/layered_layouts.hpp"

#include <cmath>
#include <numbers>
#include <numeric>

namespace matpoint {
namespace {

constexpr Real k_particles_max = 1e8;

/// Layers from one of thickness `first / ratio` on, each `ratio` times thinner, until together they are at least `needed` thick. Throws
/// InputError when all layers together never are.
int count_layers(Real first, Real ratio, Real needed) {
  // sum over k = 1, 2, ... of first / ratio^k
  const Real limit = first / (ratio - 1);
  if (!(needed < limit)) {
    throw InputError(
        "layers that get thinner by ratio = {} fill at most {:.6g} m, but {:.6g} m lie between the core and the surface; take a smaller "
        "ratio, fewer points or a larger core",
        ratio, limit, needed);
  }
  int count = 0;
  Real sum = 0;
  Real thickness = first;
  while (sum < needed) {
    thickness /= ratio;
    sum += thickness;
    ++count;
    if (count > 10000) throw InputError("ratio = {} makes more than 10000 layers; take a larger ratio or a larger core", ratio);
  }
  return count;
}

/// The ratio with which `count` layers from thickness `first / ratio` on, each `ratio` times thinner, are `needed` thick together.
Real ratio_of_layers(Real first, int count, Real needed) {
  const auto thickness = [&](Real ratio) {
    Real sum = 0;
    for (int k = count; k > 0; --k) sum = (sum + first) / ratio;
    return sum;
  };
  // thickness falls from infinity to 0 with the ratio.
  Real low = 0;
  Real high = 1;
  while (thickness(high) > needed) high *= 2;
  while (true) {
    const Real middle = 0.5 * (low + high);
    if (middle == low || middle == high) return middle;
    (thickness(middle) > needed ? low : high) = middle;
  }
}

/// The particles' volumes scaled so that their sum is the body's, where that is asked for.
void normalize(Seeds& seeds, Real measure, bool is_wanted) {
  if (!is_wanted) return;
  const Real sum = std::accumulate(seeds.volume.begin(), seeds.volume.end(), Real{0});
  for (Real& volume : seeds.volume) volume *= measure / sum;
}

void require_2d(const SeedingGrid& grid, const char* name) {
  if (grid.dim != 2) throw InputError("layout type = \"{}\" is for dim = 2", name);
}

struct LayeredDisk final : Layout {
  static constexpr auto name = "layered_disk";
  static constexpr auto summary =
      "A disk, 2D only: rings of equal distance in the core, and around it rings that get closer and denser towards the surface.";

  Real core_radius = 0;
  int points = 0;
  std::optional<Real> ratio;
  std::optional<int> layers;
  bool is_normalized = true;

  static void declare(ParameterTable<LayeredDisk>& table) {
    table.required("core_radius", "m", &LayeredDisk::core_radius, positive(), "Radius of the core, below the disk's.");
    table.required("points", "1", &LayeredDisk::points, between_closed(7, 1e6), "Particles on the outermost ring of the core.");
    table.optional("ratio", "1", &LayeredDisk::ratio, between(1, 10),
                   "Each layer is so many times thinner than the one inside it; as many layers as reach the edge. 1.14 if neither this nor "
                   "layers is given.");
    table.optional("layers", "1", &LayeredDisk::layers, between_closed(1, 10000),
                   "Instead of ratio: the number of layers, whose ratio then follows, so that the last one ends at the edge.");
    table.optional("normalized", "1", &LayeredDisk::is_normalized, any_number(),
                   "Whether volumes are scaled to the disk's area; the last layer may reach a little over its edge.");
  }
  void check(const Input& input, const ReadContext& context) const override {
    if (ratio && layers) fail_input(input, context, "ratio and layers are both given; give one of them");
  }
  // The generator of Aulisa & Capodaglio: with `layers` as its appendix A has it, with a fixed ratio as its particle counts have it.
  Seeds fill(const Region* region, const SeedingGrid& grid) const override {
    require_2d(grid, name);
    const auto* disk = dynamic_cast<const Disk*>(region);
    if (disk == nullptr) throw InputError("layout type = \"layered_disk\" fills disks only");
    if (!(core_radius < disk->radius)) {
      throw InputError("core_radius = {} m must be below the disk's radius, {} m", core_radius, disk->radius);
    }
    constexpr Real pi = std::numbers::pi;
    const int rings = static_cast<int>(layers ? std::ceil(points / (2 * pi)) : std::floor(points / (2 * pi)));
    Real spacing = core_radius / rings;
    const Real width = disk->radius - core_radius;
    const Real factor = layers ? ratio_of_layers(spacing, *layers, width) : ratio.value_or(1.14);
    if (!(factor > 1)) {
      throw InputError(
          "layers = {} of at most {:.6g} m cannot fill the {:.6g} m between the core and the edge getting thinner; give at least {}",
          *layers, spacing, width, static_cast<int>(std::floor(width / spacing)) + 1);
    }
    const int layer_count = layers ? *layers : count_layers(spacing, factor, width);
    Seeds seeds;
    const auto add_ring = [&](Real r, Real count, Real volume) {
      if (static_cast<Real>(seeds.position.size()) + count > k_particles_max)
        throw InputError("ratio = {:.6g} with points = {} makes more than {:.0g} particles", factor, points, k_particles_max);
      for (int j = 0; j < static_cast<int>(count); ++j) {
        const Real angle = 2 * pi * j / count;
        seeds.position.push_back({disk->center[0] + r * std::cos(angle), disk->center[1] + r * std::sin(angle), 0});
        seeds.volume.push_back(volume);
      }
    };
    seeds.position.push_back({disk->center[0], disk->center[1], 0});
    seeds.volume.push_back(0);
    for (int i = 0; i < rings; ++i) {
      // points r / core_radius, rounded up in whole numbers: rounding of the quotient must not add a particle.
      const Index share = static_cast<Index>(points) * (rings - i);
      add_ring(core_radius - i * spacing, static_cast<Real>((share + rings - 1) / rings), 0);
    }
    seeds.volume.assign(seeds.position.size(), pi * core_radius * core_radius / static_cast<Real>(seeds.position.size()));
    Real r = core_radius;
    Real count = points;
    for (int k = 1; k <= layer_count; ++k) {
      spacing /= factor;
      r += spacing;
      count = std::ceil(layers ? points * std::pow(factor, k) : count * factor);
      add_ring(r, count, r * (2 * pi / count) * spacing);
    }
    normalize(seeds, pi * disk->radius * disk->radius, is_normalized);
    return seeds;
  }
  Input write(int dim) const override { return write_typed(*this, dim); }
};

struct LayeredBeam final : Layout {
  static constexpr auto name = "layered_beam";
  static constexpr auto summary =
      "A beam clamped at its left side, 2D only: an even lattice in the core, and layers that get thinner at top, right and bottom.";

  Real core_height = 0;
  int rows = 0;
  Real ratio = 1.148;
  bool is_normalized = true;

  static void declare(ParameterTable<LayeredBeam>& table) {
    table.required("core_height", "m", &LayeredBeam::core_height, positive(), "Height of the core, below the box's.");
    table.required("rows", "1", &LayeredBeam::rows, between_closed(2, 1e5), "Rows of particles in the core, on its edges, too.");
    table.optional("ratio", "1", &LayeredBeam::ratio, between(1, 10), "Each layer is so many times thinner than the one inside it.");
    table.optional("normalized", "1", &LayeredBeam::is_normalized, any_number(), "Whether volumes are scaled to the box's area.");
  }
  // The generator of Aulisa & Capodaglio (appendix A), with distances that shrink from layer to layer, which gives its counts.
  Seeds fill(const Region* region, const SeedingGrid& grid) const override {
    require_2d(grid, name);
    const Input written = region->write(2);
    const Input* const type = written.find("type");
    if (type == nullptr || type->text() != "\"box\"") throw InputError("layout type = \"layered_beam\" fills boxes only");
    const Vec3 lower = region->lower();
    const Vec3 upper = region->upper();
    const Real length = upper[0] - lower[0];
    const Real height = upper[1] - lower[1];
    const Real middle = 0.5 * (lower[1] + upper[1]);
    if (!(core_height < height)) throw InputError("core_height = {} m must be below the box's height, {} m", core_height, height);
    Real dy = core_height / (rows - 1);
    Real layer_length = length - (height - core_height) / 2;
    if (!(layer_length > 0)) throw InputError("the box is too short for layers of {} m on its right side", (height - core_height) / 2);
    const int columns = static_cast<int>(std::ceil(layer_length / dy)) + 1;
    Real dx = layer_length / (columns - 1);
    if (static_cast<Real>(rows) * columns > k_particles_max)
      throw InputError("rows = {} makes more than {:.0g} particles", rows, k_particles_max);
    const int layers = count_layers(dy, ratio, (height - core_height) / 2) - 1;
    Seeds seeds;
    const Real core_volume = layer_length * core_height / (static_cast<Real>(rows) * columns);
    for (int j = 0; j < rows; ++j) {
      for (int i = 0; i < columns; ++i) {
        seeds.position.push_back({lower[0] + i * dx, middle - 0.5 * core_height + j * dy, 0});
        seeds.volume.push_back(core_volume);
      }
    }
    Real layer_height = core_height;
    for (int k = 0; k < layers; ++k) {
      dx /= ratio;
      dy /= ratio;
      layer_length += dx;
      layer_height += 2 * dy;
      const int along = static_cast<int>(std::ceil(layer_length / dx)) + 1;
      const int across = static_cast<int>(std::ceil(layer_height / dy)) + 1;
      if (static_cast<Real>(seeds.position.size()) + 2.0 * along + across > k_particles_max)
        throw InputError("ratio = {} with rows = {} makes more than {:.0g} particles", ratio, rows, k_particles_max);
      const Real top = middle + 0.5 * layer_height;
      const Real bottom = middle - 0.5 * layer_height;
      const Real right = lower[0] + layer_length;
      const auto add = [&](Real x, Real y) {
        seeds.position.push_back({x, y, 0});
        seeds.volume.push_back(dx * dy);
      };
      for (int i = 0; i < along; ++i) add(lower[0] + layer_length * i / (along - 1), top);
      for (int j = 0; j < across - 1; ++j) add(right, bottom + layer_height * j / (across - 1));
      for (int i = 0; i < along - 1; ++i) add(lower[0] + layer_length * i / (along - 1), bottom);
    }
    normalize(seeds, length * height, is_normalized);
    return seeds;
  }
  Input write(int dim) const override { return write_typed(*this, dim); }
};

}  // namespace

void add_layered_layouts(TypeRegistry<Layout>& registry) {
  registry.add<LayeredDisk>();
  registry.add<LayeredBeam>();
}

}  // namespace matpoint
