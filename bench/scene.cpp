#include "scene.hpp"

#include <cmath>
#include <numbers>
#include <random>

namespace matpoint::bench {
namespace {

constexpr double k_radius = 0.44;          // [m]
constexpr double k_approach_speed = 0.05;  // [m/s], of each body
constexpr double k_courant = 0.2;          // wave speed * dt / cell size: the particles move about 1 % of a cell in a step

Vec3 centre_of(std::size_t body, int dim, double gap) {
  const double x = k_radius + gap / 2;
  return {body == 0 ? 1 - x : 1 + x, 0.5, dim == 3 ? 0.5 : 0};
}

class BodyVelocity final : public VelocityField {
 public:
  BodyVelocity(std::size_t body, int dim, double gap) : body_(body), dim_(dim), centre_(centre_of(body, dim, gap)) {}
  Vec3 at(const Vec3& x) const override {
    const double rx = x[0] - centre_[0];
    const double ry = x[1] - centre_[1];
    const double rz = x[2] - centre_[2];
    Vec3 v{(body_ == 0 ? k_approach_speed : -k_approach_speed) + 0.03 * rx - 0.05 * ry, 0.04 * rx - 0.02 * ry, 0};
    if (dim_ == 3) {
      v[0] += 0.02 * rz;
      v[2] = 0.01 * rx - 0.03 * ry + 0.02 * rz;
    }
    return v;
  }
  Input write(int) const override { return Input::table(); }

 private:
  std::size_t body_;
  int dim_;
  Vec3 centre_;
};

int cells_across(int dim, std::size_t particles) {
  const double spheres = dim == 2 ? 2 * std::numbers::pi * k_radius * k_radius : 8 * std::numbers::pi / 3 * std::pow(k_radius, 3);
  const double per_unit_cell = spheres * std::pow(2.0, dim);
  return std::max(8, static_cast<int>(std::lround(std::pow(static_cast<double>(particles) / per_unit_cell, 1.0 / dim))));
}

/// Calls add(x) for the sites of a body's lattice.
template <class F>
void for_each_site(const Scene& scene, const std::array<int, 3>& cells, const Vec3& centre, F&& add) {
  const double h = scene.cell_size / 2;
  const int layers = scene.dim == 3 ? 2 * cells[2] : 1;
  for (int k = 0; k < layers; ++k) {
    for (int j = 0; j < 2 * cells[1]; ++j) {
      for (int i = 0; i < 2 * cells[0]; ++i) {
        const Vec3 x{(i + 0.5) * h, (j + 0.5) * h, scene.dim == 3 ? (k + 0.5) * h : 0};
        const Vec3 r{x[0] - centre[0], x[1] - centre[1], x[2] - centre[2]};
        if (r[0] * r[0] + r[1] * r[1] + r[2] * r[2] <= k_radius * k_radius) add(x);
      }
    }
  }
}

void fill_body(Scene& scene, const std::array<int, 3>& cells, std::size_t body, const SceneSpec& spec) {
  const auto dims = static_cast<std::size_t>(scene.dim);
  const Vec3 centre = centre_of(body, scene.dim, scene.gap);
  const BodyVelocity velocity(body, scene.dim, scene.gap);
  std::mt19937_64 random(body + 1);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53 - 0.5; };
  for_each_site(scene, cells, centre, [&](Vec3 x) {
    if (spec.arrangement == Arrangement::jitter) {
      for (std::size_t d = 0; d < dims; ++d) x[d] += scene.cell_size / 2 * uniform();
    }
    if (spec.arrangement == Arrangement::random) {
      double r2 = 1;
      while (r2 > k_radius * k_radius) {
        r2 = 0;
        for (std::size_t d = 0; d < dims; ++d) {
          const double r = 2 * k_radius * uniform();
          x[d] = centre[d] + r;
          r2 += r * r;
        }
      }
    }
    scene.position[body].push_back(x);
    scene.velocity[body].push_back(spec.is_at_rest ? Vec3{} : velocity.at(x));
  });
}

}  // namespace

Scene make_scene(const SceneSpec& spec) {
  const int dim = spec.dim;
  Scene scene;
  scene.dim = dim;
  scene.is_at_rest = spec.is_at_rest;
  const int across = cells_across(dim, spec.particles);
  scene.cell_size = 1.0 / across;
  scene.gap = spec.gap * scene.cell_size;
  const std::array<int, 3> cells{2 * across, across, dim == 3 ? across : 1};
  const double stretch = std::pow(spec.box_factor, 1.0 / dim);
  for (std::size_t d = 0; d < 3; ++d)
    scene.cells[d] = d < static_cast<std::size_t>(dim) ? static_cast<int>(std::lround(cells[d] * stretch)) : 1;
  scene.density = 1000;
  scene.youngs_modulus = 1000;
  scene.poissons_ratio = 0.3;
  scene.volume = std::pow(scene.cell_size / 2, dim);
  // Linear shapes with the stress updated last need it: a node that only a corner of a particle reaches would get any acceleration.
  // With USL, nodes at which a random layout happens to put hardly any mass would turn particles inside out within ten steps.
  scene.mass_cutoff = (spec.arrangement == Arrangement::random ? 0.1 : 0.01) * scene.density * scene.volume;
  const double nu = scene.poissons_ratio;
  const double wave_speed = std::sqrt(scene.youngs_modulus * (1 - nu) / ((1 + nu) * (1 - 2 * nu) * scene.density));
  scene.dt = k_courant * scene.cell_size / wave_speed;
  for (std::size_t body = 0; body < 2; ++body) fill_body(scene, cells, body, spec);
  return scene;
}

Case make_case(const Scene& scene, const SolverSpec& solver, const std::optional<Input>& law) {
  Case problem;
  problem.name = "bench";
  problem.dim = scene.dim;
  for (std::size_t d = 0; d < static_cast<std::size_t>(scene.dim); ++d) {
    problem.grid.upper[d] = scene.cells[d] * scene.cell_size;
    problem.grid.cells.push_back(scene.cells[d]);
  }
  problem.solver = solver;
  problem.solver.flip = 1;
  problem.solver.mass_cutoff = scene.mass_cutoff;
  problem.time.dt = scene.dt;
  Input elastic = Input::table();
  elastic.set("type", Input::string("neo_hookean"));
  elastic.set("density", Input::real(scene.density));
  elastic.set("youngs_modulus", Input::real(scene.youngs_modulus));
  elastic.set("poissons_ratio", Input::real(scene.poissons_ratio));
  for (std::size_t body = 0; body < 2; ++body) {
    BodySpec spec;
    spec.name = body == 0 ? "left" : "right";
    Seeds seeds{scene.position[body], std::vector<Real>(scene.position[body].size(), scene.volume)};
    spec.layout = points_layout(std::move(seeds.position), std::move(seeds.volume));
    if (!scene.is_at_rest) spec.velocity = std::make_shared<BodyVelocity>(body, scene.dim, scene.gap);
    spec.material = material_registry().read(law.value_or(elastic), {scene.dim, "bench"}, "material");
    problem.bodies.push_back(std::move(spec));
  }
  return problem;
}

}  // namespace matpoint::bench
