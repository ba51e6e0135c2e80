#include "material/point_test.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "material/function_material.hpp"
#include "material/tangent.hpp"

namespace matpoint {
namespace {

constexpr Material::Matrix k_identity{1, 0, 0, 0, 1, 0, 0, 0, 1};

Mat3<Real> to_mat3(const Material::Matrix& a) {
  Mat3<Real> result;
  std::copy(a.begin(), a.end(), result.entries);
  return result;
}

Material::Matrix diagonal(Real x, Real y, Real z) { return {x, 0, 0, 0, y, 0, 0, 0, z}; }

/// rho0 c^2 [Pa], the stiffness that tolerances are measured by.
Real stiffness(const Material& material) { return material.density() * std::pow(material.wave_speed(1), 2); }

/// The y near `start` with f(y) = 0, f a stress: Newton's method with differences, and bisection where it leaves a bracket.
template <class F>
Real solve(F&& f, Real start, Real tolerance) {
  constexpr Real k_step = 1e-7, k_widest = 0.5;
  Real y = start, value = f(y);
  Real low = start - k_widest, high = start + k_widest;
  bool has_low = false, has_high = false;
  for (int i = 0; i < 200 && std::abs(value) > tolerance; ++i) {
    if (value < 0) {
      low = y;
      has_low = true;
    } else {
      high = y;
      has_high = true;
    }
    const Real slope = (f(y + k_step) - f(y - k_step)) / (2 * k_step);
    Real next = slope > 0 ? y - value / slope : y - std::copysign(0.01, value);
    if (has_low && has_high && !(next > low && next < high)) next = 0.5 * (low + high);
    if (has_low && has_high && high - low < 1e-15) break;
    y = std::clamp(next, start - k_widest, start + k_widest);
    value = f(y);
  }
  if (std::abs(value) > 1e3 * tolerance) throw SolverError("no stretch holds the stress: {:.3g} Pa are left", value);
  return y;
}

}  // namespace

MaterialPoint::MaterialPoint(std::shared_ptr<const Material> material)
    : material_(std::move(material)), history_(static_cast<std::size_t>(material_->history_size(3)), 0) {
  // Without it a gas has no shocks, which a point does not see either; but nothing would break or soften.
  if (material_->needs_length() && !material_->is_gas())
    throw InputError("the material of a point needs `length` [m], the cell size that it breaks or softens with; allowed: > 0");
  stress_ = step_to(k_identity, 1).stress;
}

MaterialPoint::Step MaterialPoint::step_to(const Material::Matrix& F, Real dt) const {
  const Real J = determinant(to_mat3(F));
  if (!(J > 0)) throw SolverError("det F = {:.6g} of the point is not positive", J);
  const Mat3<Real> now = to_mat3(F_);
  // A = F F_n^-1
  const Mat3<Real> A = scaled(1 / determinant(now), to_mat3(F) * transpose(cofactor(now)));
  Step step{{}, history_, 0};
  if (const TangentFunction<3> evaluate = tangent_function<3>(*material_)) {
    Real S[9];
    TangentPoints point;
    point.count = 1;
    point.dt = dt;
    point.A = A.entries;
    point.F = F_.data();
    point.history = history_.data();
    point.S = S;
    point.new_history = step.history.data();
    point.tau = step.stress.data();
    point.dissipated = &step.dissipated;
    evaluate(material_->law_data(), point);
  } else {
    // (A - I) A^-1 / dt
    const Mat3<Real> L = scaled(1 / dt, Mat3<Real>::identity() - scaled(1 / determinant(A), transpose(cofactor(A))));
    Material::Matrix tau{};
    const auto& function = dynamic_cast<const FunctionMaterial&>(*material_);
    function.evaluate({1, F.data(), L.entries, dt, step.history.data(), tau.data()});
    step.stress = components_of(tau);
  }
  for (Real& component : step.stress) {
    component /= J;
    if (!std::isfinite(component)) throw SolverError("the stress of the point is not finite at det F = {:.6g}", J);
  }
  return step;
}

void MaterialPoint::move_to(const Material::Matrix& F, Real dt) {
  Step step = step_to(F, dt);
  stress_ = step.stress;
  history_ = std::move(step.history);
  dissipated_ += step.dissipated;
  F_ = F;
}

void MaterialPoint::press(Real pressure) {
  const auto F = [](Real log) { return diagonal(std::exp(log), std::exp(log), std::exp(log)); };
  const Real y = solve([&](Real log) { return material_->kirchhoff_stress(F(log))[0] + pressure; }, 0, 1e-11 * stiffness(*material_));
  material_->deform_history(F(y), history_);
  stress_ = components_of(material_->kirchhoff_stress(F_, history_));
}

std::array<Real, 6> MaterialPoint::stress_at(const Material::Matrix& F, Real dt) const { return step_to(F, dt).stress; }

const std::vector<std::string>& point_test_paths() {
  static const std::vector<std::string> names = {"uniaxial_strain", "uniaxial_stress", "triaxial",     "triaxial_undrained", "biaxial",
                                                 "isotropic",       "simple_shear",    "cyclic_shear", "deformation"};
  return names;
}

void PointTestSpec::declare(ParameterTable<PointTestSpec>& table) {
  table.required("path", "1", &PointTestSpec::path, any_number(),
                 "What is driven and what is held: " + list_names(point_test_paths()) + ".");
  table.optional("strain", "1", &PointTestSpec::strain, any_number(), "Where it ends, tension positive.");
  table.optional("confining", "Pa", &PointTestSpec::confining, non_negative(), "Pressure that the point is brought to first.");
  table.optional("rate", "1/s", &PointTestSpec::rate, positive(), "Strain per time.");
  table.optional("steps", "1", &PointTestSpec::steps, between_closed(1, 1e6), "Steps of the path, or of each of its parts.");
  table.optional("cycles", "1", &PointTestSpec::cycles, between_closed(1, 1e4), "Of cyclic_shear.");
  table.optional("times", "s", &PointTestSpec::times, non_negative(), "Of deformation: ascending, from 0 on.");
  table.optional("deformation", "1", &PointTestSpec::deformation, any_number(),
                 "Of deformation: F at these times, 9 numbers each, row by row; linear between them.");
}

namespace {

class Test {
 public:
  Test(std::shared_ptr<const Material> material, const PointTestSpec& spec)
      : spec_(spec), point_(std::move(material)), tolerance_(1e-11 * stiffness(point_.material())) {
    result_.names = {"time", "strain"};
    result_.units = {"s", "1"};
    for (const char* name : {"stress_xx", "stress_yy", "stress_zz", "stress_xy", "stress_yz", "stress_xz", "p", "q"})
      add_column(name, "Pa");
    for (const char* name : {"F_xx", "F_xy", "F_yy", "F_zz", "J"}) add_column(name, "1");
    add_column("energy", "J/m^3");
    add_column("dissipated", "J/m^3");
    for (const InternalVariable& variable : point_.material().internal_variables()) add_column(variable.name, variable.unit);
  }

  PointTestResult run() {
    if (spec_.confining > 0) confine();
    start_ = point_.F();
    record(0);
    const std::string& path = spec_.path;
    if (path == "deformation") {
      follow();
      return std::move(result_);
    }
    if (path == "simple_shear" || path == "cyclic_shear") {
      std::vector<Real> turns = {spec_.strain};
      for (int cycle = 0; path == "cyclic_shear" && cycle < spec_.cycles; ++cycle) {
        turns.push_back(-spec_.strain);
        turns.push_back(spec_.strain);
      }
      Real from = 0;
      for (const Real to : turns) {
        drive(from, to, [&](Real gamma, Real) {
          Material::Matrix F = start_;
          F[1] = gamma * start_[4];
          return F;
        });
        from = to;
      }
      return std::move(result_);
    }
    drive(0, spec_.strain, [&](Real strain, Real dt) { return stretched(strain, dt); });
    return std::move(result_);
  }

 private:
  void add_column(const std::string& name, const std::string& unit) {
    result_.names.push_back(name);
    result_.units.push_back(unit);
  }

  /// Isotropic, to the confining pressure, in equal steps of it.
  void confine() {
    if (point_.material().has_state()) {
      point_.press(spec_.confining);
      return;
    }
    constexpr int k_steps = 20;
    Real y = 0;
    for (int n = 1; n <= k_steps; ++n) {
      const Real pressure = spec_.confining * n / k_steps;
      const auto F = [](Real log) { return diagonal(std::exp(log), std::exp(log), std::exp(log)); };
      y = solve([&](Real log) { return point_.stress_at(F(log), 1)[0] + pressure; }, y, tolerance_);
      point_.move_to(F(y), 1);
    }
  }

  Material::Matrix stretched(Real strain, Real dt) {
    const Real x = start_[0] * std::exp(strain);
    const auto held = [&](auto&& F) {
      across_ = solve([&](Real log) { return point_.stress_at(F(log), dt)[1] + spec_.confining; }, across_, tolerance_);
      return F(across_);
    };
    const Real y0 = start_[4], z0 = start_[8];
    if (spec_.path == "isotropic") {
      const Real s = std::exp(strain / 3);
      return diagonal(start_[0] * s, y0 * s, z0 * s);
    }
    if (spec_.path == "triaxial_undrained") return diagonal(x, y0 * std::exp(-strain / 2), z0 * std::exp(-strain / 2));
    if (spec_.path == "biaxial") return held([&](Real log) { return diagonal(x, y0 * std::exp(log), z0); });
    if (spec_.path == "uniaxial_strain") return diagonal(x, y0, z0);
    return held([&](Real log) { return diagonal(x, y0 * std::exp(log), z0 * std::exp(log)); });
  }

  /// The given F, on top of the confinement.
  void follow() {
    const Mat3<Real> start = to_mat3(start_);
    for (std::size_t i = 1; i < spec_.times.size(); ++i) {
      const Real dt = (spec_.times[i] - spec_.times[i - 1]) / spec_.steps;
      for (int n = 1; n <= spec_.steps; ++n) {
        Mat3<Real> F;
        for (std::size_t k = 0; k < 9; ++k) {
          const Real from = spec_.deformation[9 * i - 9 + k], to = spec_.deformation[9 * i + k];
          F.entries[k] = from + (to - from) * n / spec_.steps;
        }
        F = F * start;
        Material::Matrix matrix;
        std::copy(F.entries, F.entries + 9, matrix.begin());
        time_ += dt;
        try {
          point_.move_to(matrix, dt);
        } catch (const SolverError& error) {
          throw SolverError("deformation at t = {:.6g} s: {}", time_, error.what());
        }
        record(F.entries[0] - 1);
      }
    }
  }

  template <class F_of>
  void drive(Real from, Real to, F_of&& F_of_strain) {
    const Real dt = std::max(std::abs(to - from), Real{1e-300}) / spec_.rate / spec_.steps;
    for (int n = 1; n <= spec_.steps; ++n) {
      const Real strain = from + (to - from) * n / spec_.steps;
      try {
        point_.move_to(F_of_strain(strain, dt), dt);
      } catch (const SolverError& error) {
        throw SolverError("{} at a strain of {:.6g}: {}", spec_.path, strain, error.what());
      }
      time_ += dt;
      record(strain);
    }
  }

  void record(Real strain) {
    const std::array<Real, 6> s = point_.stress();
    const Real mean = (s[0] + s[1] + s[2]) / 3;
    Real shear = 0;
    for (std::size_t d = 0; d < 3; ++d) shear += 1.5 * std::pow(s[d] - mean, 2) + 3 * s[d + 3] * s[d + 3];
    const Material::Matrix& F = point_.F();
    std::vector<Real> row = {time_, strain};
    row.insert(row.end(), s.begin(), s.end());
    for (const Real value :
         {-mean, std::sqrt(shear), F[0], F[1], F[4], F[8], determinant(to_mat3(F)), point_.energy(), point_.dissipated()})
      row.push_back(value);
    const std::vector<InternalVariable> variables = point_.material().internal_variables();
    const std::size_t first = point_.history().size() - variables.size();
    for (std::size_t i = 0; i < variables.size(); ++i) row.push_back(variables[i].at_rest + point_.history()[first + i]);
    result_.rows.push_back(std::move(row));
  }

  PointTestSpec spec_;
  MaterialPoint point_;
  Real tolerance_;
  Material::Matrix start_ = k_identity;
  Real across_ = 0;  ///< Logarithm of the stretch that holds the stress.
  Real time_ = 0;
  PointTestResult result_;
};

}  // namespace

PointTestResult run_point_test(std::shared_ptr<const Material> material, const PointTestSpec& spec) {
  const std::vector<std::string>& paths = point_test_paths();
  if (std::find(paths.begin(), paths.end(), spec.path) == paths.end()) {
    throw InputError("path = \"{}\" is unknown, allowed: {}{}", printable(spec.path), list_names(paths), did_you_mean(spec.path, paths));
  }
  const bool is_followed = spec.path == "deformation";
  if (is_followed && (spec.times.size() < 2 || spec.deformation.size() != 9 * spec.times.size())) {
    throw InputError("path = \"deformation\" needs two times or more, and 9 numbers of deformation for each; got {} times and {} numbers",
                     spec.times.size(), spec.deformation.size());
  }
  for (std::size_t i = 1; i < spec.times.size(); ++i) {
    if (!is_followed) throw InputError("times are for path = \"deformation\", and path = \"{}\"", spec.path);
    if (!(spec.times[i] > spec.times[i - 1])) throw InputError("times must ascend: {} is followed by {}", spec.times[i - 1], spec.times[i]);
  }
  if (is_followed) {
    for (int k = 0; k < 9; ++k) {
      if (std::abs(spec.deformation[static_cast<std::size_t>(k)] - (k % 4 == 0 ? 1 : 0)) > 1e-12)
        throw InputError("the first deformation must be the identity: the point starts there");
    }
  }
  return Test(std::move(material), spec).run();
}

}  // namespace matpoint
