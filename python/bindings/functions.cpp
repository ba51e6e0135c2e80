#include "functions.hpp"

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <atomic>
#include <cmath>

#include "case/case.hpp"
#include "convert.hpp"
#include "core/error.hpp"
#include "geometry/layout.hpp"
#include "material/function_material.hpp"

namespace matpoint::python {
namespace {

/// A Python object that threads without the interpreter's lock may copy and drop.
class Function {
 public:
  explicit Function(nb::object object)
      : object_(new nb::object(std::move(object)), [](nb::object* pointer) {
          const nb::gil_scoped_acquire lock;
          delete pointer;
        }) {}
  template <class... Args>
  nb::object operator()(Args&&... args) const {
    return (*object_)(std::forward<Args>(args)...);
  }

 private:
  std::shared_ptr<nb::object> object_;
};

std::atomic<bool> g_was_interrupted{false};

/// The call, and once more if Ctrl-C met it: half a step is worth nothing.
template <class F>
auto finish_despite_interrupts(F&& f) {
  try {
    return f();
  } catch (const nb::python_error& error) {
    if (!error.matches(PyExc_KeyboardInterrupt)) throw;
    g_was_interrupted = true;
  }
  return f();
}

/// Points that a Python predicate chooses; called one point at a time while particles are made.
class PredicateRegion final : public Region {
 public:
  PredicateRegion(nb::object predicate, int dim, Vec3 lower, Vec3 upper)
      : predicate_(std::move(predicate)), dim_(dim), lower_(lower), upper_(upper) {}
  bool contains(const Vec3& x) const override {
    for (std::size_t d = 0; d < static_cast<std::size_t>(dim_); ++d) {
      if (!(x[d] >= lower_[d] && x[d] <= upper_[d])) return false;
    }
    const nb::gil_scoped_acquire lock;
    return nb::cast<bool>(predicate_(make_array({x.begin(), x.begin() + dim_}, {1, static_cast<std::size_t>(dim_)})));
  }
  Vec3 lower() const override { return lower_; }
  Vec3 upper() const override { return upper_; }
  std::optional<Real> measure(int) const override { return std::nullopt; }
  Input write(int) const override { return Input::string("a region chosen by a function"); }

 private:
  Function predicate_;
  int dim_;
  Vec3 lower_;
  Vec3 upper_;
};

/// Nodes of the grid that were chosen before the run: no Python during it.
class NodeSet final : public Region {
 public:
  /// axes: the nodes' coordinates [m] in each direction, ascending.
  NodeSet(std::vector<std::vector<Real>> axes, std::vector<bool> is_chosen) : axes_(std::move(axes)), is_chosen_(std::move(is_chosen)) {}
  bool contains(const Vec3& x) const override {
    std::size_t node = 0;
    for (std::size_t d = axes_.size(); d-- > 0;) {
      const std::vector<Real>& axis = axes_[d];
      auto i = static_cast<std::size_t>(std::lower_bound(axis.begin(), axis.end(), x[d]) - axis.begin());
      if (i == axis.size() || (i > 0 && x[d] - axis[i - 1] < axis[i] - x[d])) --i;
      // Beyond the sides there is no node, only rounding.
      const Real spacing = axis[1] - axis[0];
      if (std::abs(x[d] - axis[i]) > spacing && (i == 0 || i + 1 == axis.size())) return false;
      node = node * axis.size() + i;
    }
    return is_chosen_[node];
  }
  Vec3 lower() const override { return end(false); }
  Vec3 upper() const override { return end(true); }
  std::optional<Real> measure(int) const override { return std::nullopt; }
  Input write(int) const override { return Input::string("nodes chosen by a function"); }

 private:
  Vec3 end(bool is_upper) const {
    Vec3 x{};
    for (std::size_t d = 0; d < axes_.size(); ++d) x[d] = is_upper ? axes_[d].back() : axes_[d].front();
    return x;
  }

  std::vector<std::vector<Real>> axes_;
  std::vector<bool> is_chosen_;
};

Vec3 to_vec3(const std::vector<Real>& values) {
  Vec3 x{};
  std::copy_n(values.begin(), std::min<std::size_t>(3, values.size()), x.begin());
  return x;
}

std::shared_ptr<Region> predicate_region(nb::object predicate, int dim, const std::vector<Real>& lower, const std::vector<Real>& upper) {
  return std::make_shared<PredicateRegion>(std::move(predicate), dim, to_vec3(lower), to_vec3(upper));
}

std::shared_ptr<Region> node_set(std::vector<std::vector<Real>> axes, nb::ndarray<nb::numpy, const bool, nb::ndim<1>, nb::c_contig> mask) {
  return std::make_shared<NodeSet>(std::move(axes), std::vector<bool>(mask.data(), mask.data() + mask.size()));
}

std::shared_ptr<Layout> points(ConstArray positions, ConstArray volumes) {
  const std::size_t dim = positions.ndim() == 2 ? positions.shape(1) : 0;
  if (dim != 2 && dim != 3) throw InputError("positions must have the shape (n, 2) or (n, 3)");
  std::vector<Vec3> x(positions.shape(0), Vec3{});
  for (std::size_t p = 0; p < x.size(); ++p) std::copy_n(positions.data() + p * dim, dim, x[p].begin());
  return points_layout(std::move(x), {volumes.data(), volumes.data() + volumes.size()});
}

std::shared_ptr<VelocityHistory> velocity_history(nb::object function, int dim) {
  auto history = std::make_shared<VelocityHistory>();
  history->at = [function = Function(std::move(function)), dim](Real t) {
    const nb::gil_scoped_acquire lock;
    const auto values = nb::cast<ConstArray>(finish_despite_interrupts([&] { return function(t); }));
    if (values.size() != static_cast<std::size_t>(dim)) {
      throw InputError("boundary velocity: the function gave {} numbers at t = {} s, it must give {}", values.size(), t, dim);
    }
    Vec3 velocity{};
    std::copy_n(values.data(), values.size(), velocity.begin());
    return velocity;
  };
  return history;
}

std::shared_ptr<BodyForce> body_force(nb::object function, int dim, bool is_constant) {
  auto force = std::make_shared<BodyForce>();
  force->is_constant = is_constant;
  force->at = [function = Function(std::move(function)), dim](Real t, const std::vector<Real>& positions, std::vector<Real>& values) {
    const nb::gil_scoped_acquire lock;
    const auto given = nb::cast<ConstArray>(finish_despite_interrupts([&] {
      return function(
          make_array(std::vector<Real>(positions), {positions.size() / static_cast<std::size_t>(dim), static_cast<std::size_t>(dim)}), t);
    }));
    if (given.size() != values.size()) {
      throw InputError("body_force: the function gave {} numbers at t = {} s, it must give {}", given.size(), t, values.size());
    }
    std::copy_n(given.data(), given.size(), values.begin());
  };
  return force;
}

std::vector<Real> copied(const Real* from, Index count) { return {from, from + count}; }

std::shared_ptr<Material> function_material(const std::string& name, nb::object function, Real density, Real wave_speed,
                                            Real kinematic_viscosity, int history_size, std::vector<std::string> history_names) {
  const auto evaluate = [function = Function(std::move(function)), history_size](const MaterialPoints& points) {
    const nb::gil_scoped_acquire lock;
    const auto n = static_cast<std::size_t>(points.count);
    const auto h = static_cast<std::size_t>(history_size);
    // Copies: what the function keeps must not change under it.
    const nb::object result = finish_despite_interrupts([&] {
      return function(make_array(copied(points.F, 9 * points.count), {n, 3, 3}), make_array(copied(points.L, 9 * points.count), {n, 3, 3}),
                      points.dt, make_array(copied(points.history, points.count * history_size), {n, h}));
    });
    const auto both = nb::cast<nb::tuple>(result);
    const auto tau = nb::cast<ConstArray>(both[0]);
    const auto history = nb::cast<ConstArray>(both[1]);
    std::copy_n(tau.data(), 9 * n, points.tau);
    std::copy_n(history.data(), n * h, points.history);
  };
  return std::make_shared<FunctionMaterial>(name, evaluate, density, wave_speed, kinematic_viscosity, history_size,
                                            std::move(history_names));
}

}  // namespace

bool take_interrupt() { return g_was_interrupted.exchange(false); }

void bind_functions(nb::module_& m) {
  nb::class_<Region>(m, "Region", "A region of the core.");
  nb::class_<Layout>(m, "Layout", "A layout of the core.");
  nb::class_<Material>(m, "Material", "A material of the core.");
  nb::class_<VelocityHistory>(m, "VelocityHistory", "A velocity as a function of time.");
  nb::class_<BodyForce>(m, "BodyForce", "A body force as a function of position and time.");
  m.def("predicate_region", &predicate_region, nb::arg("predicate"), nb::arg("dim"), nb::arg("lower"), nb::arg("upper"));
  m.def("node_set", &node_set, nb::arg("axes"), nb::arg("mask"));
  m.def("points", &points, nb::arg("positions"), nb::arg("volumes"));
  m.def("velocity_history", &velocity_history, nb::arg("function"), nb::arg("dim"));
  m.def("body_force", &body_force, nb::arg("function"), nb::arg("dim"), nb::arg("is_constant"));
  m.def("function_material", &function_material, nb::arg("name"), nb::arg("function"), nb::arg("density"), nb::arg("wave_speed"),
        nb::arg("kinematic_viscosity"), nb::arg("history_size"), nb::arg("history_names"));
}

}  // namespace matpoint::python
