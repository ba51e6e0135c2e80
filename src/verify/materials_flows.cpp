// Grains and muds that flow: experiments, closed forms, and an independent program.
#include <algorithm>
#include <cmath>

#include "verify/materials.hpp"

namespace matpoint {
namespace {

// --- Grains -------------------------------------------------------------------------------------------------------------------

/// Highest particle in a column of cells around x, plus a quarter of a cell.
Real surface(const Simulation& sim, Real x, Real h) {
  const std::vector<Real> xs = component(sim, 0, "position", 0), ys = component(sim, 0, "position", 1);
  const Real half = 0.52 * h;
  const Real at = std::max(x, h / 4);
  Real top = 0;
  for (std::size_t p = 0; p < xs.size(); ++p) {
    if (std::abs(xs[p] - at) < half) top = std::max(top, ys[p] + h / 4);
  }
  return top;
}

/// Rods of aluminium, 0.2 x 0.1 m. Bui, Fukagawa, Sako & Ohno (2008). In 3D a slab of two cells between walls without friction.
Measured rods(const std::string& prefix, const std::string& law, int dim = 2) {
  constexpr Real h = 0.005;
  const bool is_solid = dim == 3;
  const auto point = [&](Real x, Real y, Real z) {
    return is_solid ? fmt::format("[{}, {}, {}]", x, y, z) : fmt::format("[{}, {}]", x, y);
  };
  const std::vector<Real> profile = {.0992, .0959, .0844, .0722, .0616, .0474, .0348, .0265, .0189, .0109, .0037, .0015};
  Simulation sim(default_case("rods", fmt::format(R"(
dim = {}
gravity = {}
[grid]
upper = {}
cells = [120, 30{}]
[time]
end = 0.8
[[body]]
name = "rods"
region = {{ type = "box", lower = {}, upper = {} }}
layout = {{ type = "per_cell", count = {} }}
material = {{ {}, density = 2650, youngs_modulus = 0.84e6, poissons_ratio = 0.3, cohesion = 0, friction_angle = 19.8 }}
[[boundary]]
side = "bottom"
kind = "fixed"
[[boundary]]
side = "left"
kind = "slip"
)",
                                                  dim, point(0, -9.81, 0), point(0.6, 0.15, 2 * h), is_solid ? ", 2" : "", point(0, 0, 0),
                                                  point(0.2, 0.1, 2 * h), is_solid ? 8 : 4, law) +
                                          (is_solid ? slip_sides({"front", "back"}) : "")));
  sim.run();
  Real difference = 0;
  for (std::size_t k = 0; k < profile.size(); ++k) difference += std::abs(surface(sim, 0.04 * static_cast<Real>(k), h) - profile[k]);
  return {{prefix + "front", greatest(sim, 0)},
          {prefix + "profile", 1e3 * difference / static_cast<Real>(profile.size())},
          {prefix + "kinetic", kinetic_energy(sim)}};
}

/// Columns on a rough floor, L0 = 0.1 m, phi = 31 degrees: (front - L0)/L0 and height/L0. Lube, Huppert, Sparks & Freundt (2005).
Measured column(const std::string& prefix, Real aspect, const std::string& law, Real h) {
  constexpr Real L0 = 0.1;
  const Real H = aspect * L0;
  const int across = static_cast<int>(std::lround((L0 + std::max(3 * aspect, Real{2}) * 2 * L0) / h));
  const int up = static_cast<int>(std::lround(1.3 * H / h + 3));
  Simulation sim(default_case("column", fmt::format(R"(
gravity = [0, -9.81]
[grid]
upper = [{}, {}]
cells = [{}, {}]
[time]
end = 1
[[body]]
name = "column"
region = {{ type = "box", lower = [0, 0], upper = [0.1, {}] }}
layout = {{ type = "per_cell", count = 4 }}
material = {{ {}, youngs_modulus = 1e6, poissons_ratio = 0.3 }}
[[boundary]]
side = "bottom"
kind = "fixed"
[[boundary]]
side = "left"
kind = "slip"
)",
                                                    across * h, up * h, across, up, H, law)));
  sim.run();
  return {{prefix + "front", (greatest(sim, 0) - L0) / L0},
          {prefix + "front_of_most", (quantile(sim, 0, 0.995) - L0) / L0},
          {prefix + "height", greatest(sim, 1) / L0}};
}

/// The work per area [J/m^2] of a clay that is sheared by 40 mm until a band has lost four fifths of its strength.
Real work_of_band(const std::string& law, int rows, const std::string& scheme = "") {
  constexpr Real H = 0.4;
  const Real h = H / rows, middle = rows / 2 * h;
  const auto body = [&](const char* name, Real from, Real to, Real cohesion) {
    return fmt::format(R"(
[[body]]
name = "{}"
region = {{ type = "box", lower = [0, {}], upper = [{}, {}] }}
layout = {{ type = "per_cell", count = 4 }}
material = {{ {}, density = 1800, youngs_modulus = 1e7, poissons_ratio = 0.3, cohesion = {}, residual_cohesion = {}, friction_angle = 0, softening_slip = 0.02 }}
)",
                       name, from, 4 * h, to, law, cohesion, 0.2 * cohesion);
  };
  Simulation sim(default_case("band", fmt::format(R"(
[grid]
upper = [{}, {}]
cells = [4, {}]
periodic = ["x"]
[time]
end = 0.4
[[boundary]]
side = "bottom"
kind = "fixed"
[[boundary]]
side = "top"
kind = "velocity"
velocity = [0.1, 0]
)",
                                                  4 * h, H, rows) +
                                          scheme +
                                          // The band begins where it is a little weaker.
                                          body("lower", 0, middle, 1e4) + body("band", middle, middle + h, 0.98e4) +
                                          body("upper", middle + h, H, 1e4)));
  sim.run();
  return sim.solver().boundaries()[1].work / (4 * h);
}

}  // namespace

void add_grains(VerifySuite& suite) {
  // The residual strength all the way, and a triangle above it.
  constexpr Real c = 1e4, work = 0.2 * c * 0.04 + 0.5 * 0.8 * c * 0.02;
  add_problem(
      suite,
      {"softening_band",
       "a band that softens",
       "materials",
       true,
       true,
       3e6,
       {},
       [] {
         const std::string splines = "[solver]\nshape = \"bspline2\"\ntransfer = \"apic\"\n";
         const std::string mohr = "type = \"mohr_coulomb\"", cone = "type = \"drucker_prager\"";
         return Measured{{"coarse", work_of_band(mohr, 4) / work},
                         {"middle", work_of_band(mohr, 8) / work},
                         {"fine", work_of_band(mohr, 16) / work},
                         {"cone", work_of_band(cone, 8) / work},
                         {"splines", work_of_band(mohr, 8, splines) / work},
                         {"fine_splines", work_of_band(mohr, 16, splines) / work}};
       }},
      {within("coarse", 1, 0.1, "the work of the slip, whatever the cells: 100 mm"), within("middle", 1, 0.1, "50 mm"),
       within("fine", 1, 0.1, "25 mm"), within("cone", 1, 0.1, "Drucker-Prager's"),
       within("splines", 1, 0.1, "B-splines and APIC, whose bands are three cells wide: 50 mm"), within("fine_splines", 1, 0.1, "25 mm")});
  const std::string bui = "Bui et al. (2008), experiment with rods of aluminium";
  add_problem(suite,
              {"granular_rods",
               "column of rods",
               "materials",
               true,
               true,
               2.4e7,
               {},
               [] {
                 Measured measured = rods("mc_", "type = \"mohr_coulomb\"");
                 measured.merge(rods("dp_", "type = \"drucker_prager\""));
                 measured.merge(rods("compression_", "type = \"drucker_prager\", fit = \"compression\""));
                 return measured;
               }},
              {within("mc_front", 0.42, 0.02, "the same law in an independent program: 0.4205; experiment 0.44"),
               at_most("mc_profile", 3, bui + ", mean difference [mm]"), at_most("mc_kinetic", 1e-4, "it lies still"),
               within("dp_front", 0.42, 0.02, "the same law in an independent program: 0.4209"), at_most("dp_profile", 3, bui),
               at_most("dp_kinetic", 1e-4, "it lies still"),
               at_most("compression_front", 0.37, "the cone of triaxial compression is too strong in plane strain: 0.353"),
               at_least("compression_profile", 3, "it must miss the profile"), at_most("compression_kinetic", 1e-4, "it lies still")});
  const auto over_plane = [](const std::string& law) {
    Measured slab = rods("", law, 3);
    const Measured plane = rods("", law);
    return Measured{{"front", slab.at("front") / plane.at("front")}, {"profile", slab.at("profile")}, {"kinetic", slab.at("kinetic")}};
  };
  const std::string slab = "the same in plane strain";
  add_problem(suite,
              {"granular_rods",
               "column of rods in 3D",
               "materials",
               false,
               true,
               5e8,
               {},
               [over_plane] {
                 Measured measured;
                 for (const auto& [name, value] : over_plane("type = \"mohr_coulomb\"")) measured["slab_mc_" + name] = value;
                 for (const auto& [name, value] : over_plane("type = \"drucker_prager\", fit = \"plane\""))
                   measured["slab_dp_" + name] = value;
                 return measured;
               }},
              {within("slab_mc_front", 1, 0.02, slab), at_most("slab_mc_profile", 3, bui + ", mean difference [mm]"),
               at_most("slab_mc_kinetic", 1e-5, "it lies still"), within("slab_dp_front", 1, 0.02, slab),
               at_most("slab_dp_profile", 3, bui), at_most("slab_dp_kinetic", 1e-5, "it lies still")});
  const std::string lube = "Lube et al. (2005): 1.2 a";
  const std::string mohr = "type = \"mohr_coulomb\", density = 1600, cohesion = 0, friction_angle = 31";
  const std::string mu =
      "type = \"mu_i\", density = 1500, mu_s = 0.382, mu_2 = 0.644, I0 = 0.279, grain_diameter = 1e-3, grain_density = 2500";
  add_problem(
      suite,
      {"granular_columns",
       "columns of sand",
       "materials",
       true,
       true,
       3e7,
       {},
       [mohr, mu] {
         Measured measured = column("a05_", 0.5, mohr, 0.005);
         measured.merge(column("a1_", 1, mohr, 0.005));
         measured.merge(column("a3_", 3, mohr, 0.01));
         measured.merge(column("mu_i_", 1, mu, 0.005));
         return measured;
       }},
      {within("a05_front", 0.446, 0.06, lube + " +- 30 %; an independent program: 0.446"), reported("a05_front_of_most", 0.402, "the same"),
       within("a05_height", 0.499, 0.05, "the same"), within("a1_front", 1.173, 0.06, lube + " +- 30 %; an independent program: 1.173"),
       reported("a1_front_of_most", 1.086, "the same"), within("a1_height", 0.867, 0.05, "the same"),
       within("a3_front", 4.1, 0.7, "1.9 a^(2/3) = 3.95"), reported("a3_front_of_most", 3.67, "an independent program"),
       within("a3_height", 1.22, 0.05, "an independent program"), within("mu_i_front", 1.578, 0.06, "an independent program"),
       reported("mu_i_front_of_most", 1.463, "the same"), within("mu_i_height", 0.718, 0.05, "the same")});
}

namespace {

/// A layer that flows steadily down 24 degrees: v = (2/3) (I/d) sqrt(rho/rho_s g cos theta) (h^1.5 - (h - y)^1.5), tan theta = mu(I).
Measured bagnold() {
  constexpr Real h = 0.02, theta = 24 * 3.14159265358979323846 / 180, d = 1e-3, rho = 1500, rho_s = 2500;
  constexpr int cells = 8;
  const Real I = 0.279 / ((0.644 - 0.382) / (std::tan(theta) - 0.382) - 1);
  const Real factor = 2.0 / 3 * I / d * std::sqrt(rho / rho_s * 9.81 * std::cos(theta));
  const auto exact = [&](Real y) { return factor * (std::pow(h, 1.5) - std::pow(std::max(h - y, Real{0}), 1.5)); };
  const Real dx = h / cells;
  Simulation sim(
      default_case("bagnold", fmt::format(R"(
gravity = [{}, {}]
[grid]
upper = [{}, {}]
cells = [4, {}]
periodic = ["x"]
[time]
end = 4
[[body]]
name = "layer"
region = {{ type = "box", lower = [0, 0], upper = [{}, {}] }}
layout = {{ type = "per_cell", count = 4 }}
material = {{ type = "mu_i", density = 1500, youngs_modulus = 2e5, poissons_ratio = 0.3, mu_s = 0.382, mu_2 = 0.644, I0 = 0.279, grain_diameter = 1e-3, grain_density = 2500 }}
[[boundary]]
side = "bottom"
kind = "fixed"
)",
                                          9.81 * std::sin(theta), -9.81 * std::cos(theta), 4 * dx, h + 2 * dx, cells + 2, 4 * dx, h)));
  std::vector<Real> v = component(sim, 0, "velocity", 0);
  const std::vector<Real> y0 = component(sim, 0, "position", 1);
  std::vector<Real> start;
  for (const Real y : y0) {
    start.push_back(exact(y));
    start.push_back(0);
  }
  sim.set_field(0, "velocity", start);
  sim.run();
  v = component(sim, 0, "velocity", 0);
  const std::vector<Real> y = component(sim, 0, "position", 1);
  Real squares = 0;
  for (std::size_t p = 0; p < v.size(); ++p) squares += std::pow(v[p] - exact(y[p]), 2);
  const Real top = exact(h);
  return {{"surface", *std::max_element(v.begin(), v.end()) / top}, {"rms", std::sqrt(squares / static_cast<Real>(v.size())) / top}};
}

// --- Muds ---------------------------------------------------------------------------------------------------------------------

/// Bingham's fluid between plates: a plug of 0.045 m/s.
Real bingham_rms(int cells, Real& plug) {
  constexpr Real L = 0.1, plug_half = 0.02, force = 500, k = 5;
  const Real dx = L / cells;
  Simulation sim(default_case("bingham", fmt::format(R"(
gravity = [0.5, 0]
[grid]
upper = [{}, 0.1]
cells = [4, {}]
periodic = ["x"]
[time]
end = 2
[[body]]
name = "mud"
region = {{ type = "box", lower = [0, 0], upper = [{}, 0.1] }}
layout = {{ type = "per_cell", count = 4 }}
material = {{ type = "herschel_bulkley", density = 1000, youngs_modulus = 2e4, poissons_ratio = 0.45, yield_stress = 10, consistency = 5 }}
[[boundary]]
side = "bottom"
kind = "fixed"
[[boundary]]
side = "top"
kind = "fixed"
)",
                                                     4 * dx, cells, 4 * dx)));
  sim.run();
  const std::vector<Real> v = component(sim, 0, "velocity", 0), y = component(sim, 0, "position", 1);
  Real squares = 0, in_plug = 0, count = 0;
  for (std::size_t p = 0; p < v.size(); ++p) {
    const Real z = std::abs(y[p] - L / 2);
    const Real exact = force / (2 * k) * (std::pow(L / 2 - plug_half, 2) - std::pow(std::max(z - plug_half, Real{0}), 2));
    squares += std::pow(v[p] - exact, 2);
    if (z > plug_half / 2) continue;
    in_plug += v[p];
    count += 1;
  }
  plug = in_plug / count;
  return std::sqrt(squares / static_cast<Real>(v.size())) / 0.045;
}

Measured bingham() {
  Real plug_10 = 0, plug_20 = 0;
  const Real rms_10 = bingham_rms(10, plug_10), rms_20 = bingham_rms(20, plug_20);
  return {{"plug_10", plug_10}, {"plug_20", plug_20}, {"order", std::log2(rms_10 / rms_20)}};
}

/// A block of mud, 0.1 x 0.1 m, on a rough floor. The lubrication limit at rest reaches 0.2805 m (Liu & Mei 1989).
Measured slump() {
  Simulation sim(default_case("slump", R"(
gravity = [0, -9.81]
[grid]
upper = [0.4, 0.12]
cells = [80, 24]
[time]
end = 4
[[body]]
name = "mud"
region = { type = "box", lower = [0, 0], upper = [0.1, 0.1] }
layout = { type = "per_cell", count = 4 }
material = { type = "herschel_bulkley", density = 1000, youngs_modulus = 3e4, poissons_ratio = 0.3, yield_stress = 50, consistency = 20 }
[[boundary]]
side = "bottom"
kind = "fixed"
[[boundary]]
side = "left"
kind = "slip"
)"));
  sim.run();
  return {{"slump_front", greatest(sim, 0)}, {"slump_height", surface(sim, 0, 0.005)}};
}

}  // namespace

void add_flows(VerifySuite& suite) {
  add_problem(suite, {"bagnold", "grains down a slope of 24 degrees", "materials", true, true, 8e6, {}, bagnold},
              {within("surface", 1, 0.01, "Bagnold's profile, tan theta = mu(I)"), at_most("rms", 0.01, "the same")});
  add_problem(suite, {"bingham", "Bingham's fluid between plates", "materials", true, true, 4e6, {}, bingham},
              {within("plug_10", 0.045, 4.5e-5, "closed form"), within("plug_20", 0.045, 4.5e-5, "closed form"),
               at_least("order", 1.7, "second order in the cell size")});
  add_problem(suite, {"bingham_slump", "slump of a block of mud", "materials", true, true, 2e7, {}, slump},
              {within("slump_front", 0.246, 0.008, "an independent program: 0.2447, 0.2463; never above 0.2805"),
               within("slump_height", 0.05, 0.006, "the same: 0.048 to 0.055")});
}

}  // namespace matpoint
