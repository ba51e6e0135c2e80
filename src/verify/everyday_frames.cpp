// The same case mirrored, turned, moved, with its bodies in another order and looked at at other times gives the same numbers.
#include <cmath>

#include "core/error.hpp"
#include "verify/everyday.hpp"

namespace matpoint {
namespace {

/// How a case is written down: x -> width - x, then x <-> y, then moved; what is asked of the run besides.
struct Frame {
  bool is_mirrored = false, is_turned = false, is_moved = false;
  bool has_other_order = false;    ///< Bodies in the opposite order.
  bool has_other_outputs = false;  ///< 0.37 times the interval of the history.
  bool is_nudged = false;          ///< One particle in another place by 1e-13: how much the motion amplifies rounding.
};

/// Writes places and vectors of a case on [0, width] in a frame.
class Writer {
 public:
  Writer(const Frame& frame, Real width) : frame_(frame), width_(width) {}

  std::array<Real, 2> vector_of(Real x, Real y) const {
    if (frame_.is_mirrored) x = -x;
    if (frame_.is_turned) std::swap(x, y);
    return {x, y};
  }
  std::array<Real, 2> point_of(Real x, Real y) const {
    if (frame_.is_mirrored) x = width_ - x;
    if (frame_.is_turned) std::swap(x, y);
    if (frame_.is_moved) x += 4, y -= 8;
    return {x, y};
  }
  std::string vector(Real x, Real y) const { return text(vector_of(x, y)); }
  std::string point(Real x, Real y) const { return text(point_of(x, y)); }
  std::string corners(Real x0, Real y0, Real x1, Real y1) const {
    std::array<Real, 2> a = point_of(x0, y0), b = point_of(x1, y1);
    for (int d = 0; d < 2; ++d) {
      if (a[d] > b[d]) std::swap(a[d], b[d]);
    }
    return fmt::format("lower = {}, upper = {}", text(a), text(b));
  }
  std::string box(Real x0, Real y0, Real x1, Real y1) const { return "{ type = \"box\", " + corners(x0, y0, x1, y1) + " }"; }
  std::string grid(Real x0, Real y0, Real x1, Real y1, int nx, int ny) const {
    std::string lines = corners(x0, y0, x1, y1);
    lines.replace(lines.find(", upper"), 2, "\n");
    return fmt::format("[grid]\n{}\ncells = [{}, {}]\n", lines, frame_.is_turned ? ny : nx, frame_.is_turned ? nx : ny);
  }
  std::string side(std::string name) const {
    if (frame_.is_mirrored && (name == "left" || name == "right")) name = name == "left" ? "right" : "left";
    if (frame_.is_turned) name = name == "left" ? "bottom" : name == "right" ? "top" : name == "bottom" ? "left" : "right";
    return "[[boundary]]\nside = \"" + name + "\"\n";
  }
  std::string in_order(const std::vector<std::string>& bodies) const {
    std::string all;
    for (std::size_t k = 0; k < bodies.size(); ++k) all += bodies[frame_.has_other_order ? bodies.size() - 1 - k : k];
    return all;
  }

 private:
  static std::string text(const std::array<Real, 2>& v) { return fmt::format("[{}, {}]", v[0], v[1]); }
  Frame frame_;
  Real width_;
};

std::string body(const std::string& name, const std::string& region, const std::string& material, const std::string& velocity = "") {
  const std::string uniform = velocity.empty() ? "" : "velocity = { type = \"uniform\", value = " + velocity + " }\n";
  return fmt::format("[[body]]\nname = \"{}\"\nregion = {}\nlayout = {{ type = \"per_cell\", count = 4 }}\n{}{}", name, region, uniform,
                     material);
}

std::string elastic(Real density, Real E, Real nu = 0.3) {
  return fmt::format("material = {{ type = \"neo_hookean\", density = {}, youngs_modulus = {}, poissons_ratio = {} }}\n", density, E, nu);
}

/// Two disks that meet, not quite head-on.
std::string two_disks(const Writer& w, const std::string& contact) {
  const auto disk = [&](const char* name, Real x, Real y, Real radius, const std::string& velocity) {
    return body(name, fmt::format("{{ type = \"disk\", center = {}, radius = {} }}", w.point(x, y), radius), elastic(1000, 1e4), velocity);
  };
  return w.grid(0, -0.5, 1, 0.5, 20, 20) + "[solver]\ncontact = \"" + contact + "\"\n" +
         w.in_order({disk("a", 0.3, 0.02, 0.2, w.vector(0.5, 0.1)), disk("b", 0.72, 0, 0.21, w.vector(-0.5, 0))});
}

struct FramedCase {
  std::string name;
  Real width, end;
  /// The case but for its times.
  std::function<std::string(const Writer&)> text;
};

const std::vector<FramedCase>& framed_cases() {
  static const std::vector<FramedCase> cases = {
      {"fall", 1, 0.4,
       [](const Writer& w) {
         return "gravity = " + w.vector(0, -9.81) + "\n" + w.grid(0, 0, 1, 2, 20, 40) +
                body("ball", fmt::format("{{ type = \"disk\", center = {}, radius = 0.2 }}", w.point(0.5, 1.6)), elastic(7800, 2e11));
       }},
      {"floor", 2, 0.3,
       [](const Writer& w) {
         return "gravity = " + w.vector(0, -9.81) + "\n" + w.grid(0, 0, 2, 1, 20, 10) +
                body("block", w.box(0.4, 0.3, 0.8, 0.7), elastic(1000, 1e6), w.vector(1, 0)) +
                "[[boundary]]\nregion = " + w.box(-0.1, -0.1, 2.1, 0.3) + "\nkind = \"fixed\"\ncontact = \"friction\"\nfriction = 0.3\n";
       }},
      {"landing", 2, 0.25,
       [](const Writer& w) {
         return "gravity = " + w.vector(0, -9.81) + "\n" + w.grid(0, 0, 2, 1.5, 40, 30) +
                body("block", w.box(0.35, 0.3, 0.65, 0.6), elastic(2700, 1e8), w.vector(0.4, -3)) + w.side("bottom") +
                "contact = \"no_tension\"\n";
       }},
      {"disks", 1, 0.3, [](const Writer& w) { return two_disks(w, "pairs"); }},
      {"fields", 1, 0.3, [](const Writer& w) { return two_disks(w, "multi_field"); }},
      {"dam", 1, 0.25,
       [](const Writer& w) {
         return "gravity = " + w.vector(0, -9.81) + "\n" + w.grid(0, 0, 1, 1, 20, 20) +
                body("water", w.box(0, 0, 0.4, 0.6), k_everyday_water) + w.side("left") + w.side("right") + w.side("bottom") +
                w.side("top");
       }},
      {"obstacle", 0.584, 0.25,
       [](const Writer& w) {
         return "gravity = " + w.vector(0, -9.81) + "\n" + w.grid(0, 0, 0.584, 0.4, 73, 50) +
                w.in_order({body("water", w.box(0, 0, 0.144, 0.288),
                                 "material = { type = \"newtonian_fluid\", density = 1000, pressure_scale = 1e4 }\n"),
                            body("obstacle", w.box(0.28, 0, 0.304, 0.08), elastic(2500, 1e6, 0))}) +
                w.side("left") + w.side("right") + w.side("bottom") + w.side("top");
       }},
  };
  return cases;
}

/// What a run came to, bodies in the order in which the case was thought of.
struct Numbers {
  std::vector<std::array<Real, 2>> centres, momenta;
  Real energy = 0;
  Real mass = 0;
};

Numbers run_in(const FramedCase& framed, const Frame& frame, const EverydaySetting& setting) {
  const Real interval = framed.end / 25 * (frame.has_other_outputs ? 0.37 : 1);
  const std::string times = fmt::format("[time]\nend = {}\n[output]\nhistory_every = {}\n", framed.end, interval);
  Simulation sim(everyday_case(framed.text(Writer(frame, framed.width)) + times, setting));
  if (frame.is_nudged) {
    std::vector<Real> x = sim.solver().field(0, "position").values;
    x[0] += 1e-13;
    sim.set_field(0, "position", x);
  }
  sim.run();
  Numbers numbers;
  const std::size_t bodies = sim.solver().body_count();
  for (std::size_t k = 0; k < bodies; ++k) {
    const BodyTotals totals = sim.solver().totals(frame.has_other_order ? bodies - 1 - k : k);
    numbers.centres.push_back({totals.center_of_mass[0], totals.center_of_mass[1]});
    numbers.momenta.push_back({totals.momentum[0], totals.momentum[1]});
    numbers.energy += totals.kinetic_energy + totals.strain_energy;
    numbers.mass += totals.mass;
  }
  return numbers;
}

/// Greatest difference of two runs: centres to the size of the case, energies to what it has, momenta to what goes with that energy.
Real difference(const Numbers& a, const Numbers& b, const Frame& frame, Real width) {
  const Writer writer(frame, width);
  Real greatest = std::abs(b.energy - a.energy) / a.energy;
  for (std::size_t k = 0; k < a.centres.size(); ++k) {
    const auto centre = writer.point_of(a.centres[k][0], a.centres[k][1]);
    const auto momentum = writer.vector_of(a.momenta[k][0], a.momenta[k][1]);
    for (std::size_t d = 0; d < 2; ++d) {
      greatest = std::max(greatest, std::abs(b.centres[k][d] - centre[d]) / width);
      greatest = std::max(greatest, std::abs(b.momenta[k][d] - momentum[d]) / std::sqrt(2 * a.mass * a.energy));
    }
  }
  return std::isfinite(greatest) ? greatest : std::numeric_limits<Real>::infinity();
}

Measured compare_frames(const FramedCase& framed, const EverydaySetting& setting) {
  Frame mirrored, turned, moved, order, outputs, nudged;
  mirrored.is_mirrored = turned.is_turned = moved.is_moved = order.has_other_order = outputs.has_other_outputs = nudged.is_nudged = true;
  const Numbers base = run_in(framed, {}, setting);
  const auto see = [&](const Frame& frame) { return difference(base, run_in(framed, frame, setting), frame, framed.width); };
  Real greatest = std::max({see(mirrored), see(turned), see(moved), see(outputs)});
  if (base.centres.size() > 1) greatest = std::max(greatest, see(order));
  return {{"same_" + framed.name, greatest}, {"rounding_" + framed.name, see(nudged)}};
}

}  // namespace

std::vector<EverydayProblem> everyday_frames() {
  std::vector<EverydayProblem> problems;
  for (const FramedCase& framed : framed_cases()) {
    problems.push_back({"the same in other frames: " + framed.name,
                        [framed](const EverydaySetting& setting) { return compare_frames(framed, setting); },
                        [name = framed.name](bool is_single) -> std::vector<VerifyRow> {
                          return {at_most("same_" + name, is_single ? 1e-4 : 1e-9, "the same case"),
                                  at_most("rounding_" + name, is_single ? 1e-5 : 1e-10, "one particle moved by 1e-13 m")};
                        },
                        3e6, framed.name != "obstacle" && framed.name != "fall"});
  }
  return problems;
}

}  // namespace matpoint
