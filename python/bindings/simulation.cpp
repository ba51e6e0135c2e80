#include "simulation.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <chrono>
#include <cmath>
#include <mutex>
#include <set>
#include <thread>

#include "convert.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "functions.hpp"
#include "io/history.hpp"
#include "io/results_folder.hpp"
#include "io/state_file.hpp"
#include "run/restart.hpp"
#include "run/simulation.hpp"

namespace matpoint::python {
namespace {

using Clock = std::chrono::steady_clock;

/// The flags of the simulations that are going on, to end them before the interpreter goes: a thread that comes back to it then would end
/// the program with an abort.
std::mutex g_running_mutex;
std::set<std::atomic<int>*> g_running;

void end_runs() {
  const nb::gil_scoped_release unlocked;
  while (true) {
    {
      const std::lock_guard lock(g_running_mutex);
      if (g_running.empty()) return;
      for (std::atomic<int>* interrupt : g_running) *interrupt = 1;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

const char* text_of(RunEnd ending) {
  switch (ending) {
    case RunEnd::stopped_by_callback: return "stopped";
    case RunEnd::particle_left: return "stopped (a particle left the grid)";
    case RunEnd::interrupted: return "interrupted";
    case RunEnd::time_limit: return "interrupted (time limit)";
    case RunEnd::finished: break;
  }
  return "finished";
}

class PythonSimulation {
 public:
  PythonSimulation(nb::handle data, const std::string& name) : simulation_(Case::from_input(to_input(data, ""), name)) {
    for (const HistoryColumn& column : history_columns(simulation_.solver())) {
      history_names_.push_back(column.name);
      history_units_.push_back(column.unit);
    }
    simulation_.add_history_callback([this](const std::vector<Real>& row) { record(row); });
    simulation_.add_callback([this](const Simulation&) {
      look_for_signals();
      return true;
    });
  }

  const Simulation& simulation() const { return simulation_; }
  const Solver& solver() const { return simulation_.solver(); }

  void open_results(const std::string& folder, bool is_overwrite, const std::string& command) {
    require_idle();
    auto results = std::make_unique<ResultsFolder>(folder, is_overwrite ? ExistingFolder::overwrite : ExistingFolder::refuse);
    results->begin(simulation_, thread_count(), command);
    results_ = std::move(results);
  }
  bool has_results() const { return results_ != nullptr; }

  std::string run(std::optional<Real> until) {
    require_idle();
    const Running running(*this);
    RunEnd ending{};
    try {
      if (results_ && simulation_.step_count() > 0) results_->resume(simulation_);
      const nb::gil_scoped_release unlocked;
      ending = simulation_.run(results_.get(), until, {&interrupt_, nullptr, {}});
      if (results_) results_->finish(simulation_, text_of(ending));
    } catch (const SolverError& error) {
      if (!results_) throw;
      results_->fail(simulation_, error.what());
      throw SolverError("{}; written: {}", error.what(), results_->last_written());
    } catch (const std::exception& error) {
      if (results_) results_->fail(simulation_, error.what());
      throw;
    }
    raise_signal();
    return text_of(ending);
  }

  void step(Index count) {
    require_idle();
    const Running running(*this);
    {
      const nb::gil_scoped_release unlocked;
      for (Index i = 0; i < count && interrupt_ == 0; ++i) {
        simulation_.step();
        look_for_signals();
      }
    }
    raise_signal();
  }

  /// The function is called with no arguments and stops the run by returning false.
  void add_callback(nb::object function, Index every_steps, Real every_time, double every_wall) {
    require_between_steps();
    struct State {
      nb::object function;
      Real next_time;
      Clock::time_point last = Clock::now();
    };
    const Real first = every_time > 0 ? std::ceil(simulation_.time() / every_time - 1e-9) * every_time : 0;
    auto* const raw = new State{std::move(function), first};
    const std::shared_ptr<State> state(raw, [](State* pointer) {
      const nb::gil_scoped_acquire lock;
      delete pointer;
    });
    simulation_.add_callback([this, state, every_steps, every_time, every_wall](const Simulation& now) {
      if (every_steps > 0 && now.step_count() % every_steps != 0) return true;
      if (every_time > 0) {
        // The first step at or after each multiple; the steps are not cut, for watching a run must not change it.
        if (now.time() < state->next_time * (1 - 1e-12)) return true;
        state->next_time = (std::floor(now.time() / every_time + 1e-9) + 1) * every_time;
      }
      if (every_wall > 0) {
        if (std::chrono::duration<double>(Clock::now() - state->last).count() < every_wall) return true;
        state->last = Clock::now();
      }
      const nb::gil_scoped_acquire lock;
      is_in_callback_ = true;
      const bool goes_on = call(state->function);
      is_in_callback_ = false;
      return goes_on;
    });
  }

  Array history() const {
    require_between_steps();
    std::vector<Real> values;
    values.reserve(rows_.size() * history_names_.size());
    // Column by column: each becomes a contiguous array.
    for (std::size_t c = 0; c < history_names_.size(); ++c) {
      for (const std::vector<Real>& row : rows_) values.push_back(row[c]);
    }
    return make_array(std::move(values), {history_names_.size(), rows_.size()});
  }
  void record(const std::vector<Real>& row) {
    // A run that went back where a step failed.
    while (!rows_.empty() && rows_.back()[0] > row[0]) rows_.pop_back();
    if (!rows_.empty() && rows_.back()[0] == row[0]) return;
    rows_.push_back(row);
  }
  void record_now() {
    require_between_steps();
    record(history_row(simulation_));
  }
  std::vector<std::tuple<std::string, std::vector<Real>, std::vector<Real>, Real>> boundaries() const {
    require_between_steps();
    std::vector<std::tuple<std::string, std::vector<Real>, std::vector<Real>, Real>> all;
    const auto vector = [&](const Vec3& v) { return std::vector<Real>(v.begin(), v.begin() + simulation_.solver().dim()); };
    for (const BoundaryTotals& one : simulation_.solver().boundaries())
      all.emplace_back(one.name, vector(one.force), vector(one.impulse), one.work);
    return all;
  }
  std::vector<std::tuple<std::string, std::string, bool, std::string>> health() const {
    require_between_steps();
    std::vector<std::tuple<std::string, std::string, bool, std::string>> lines;
    for (const HealthLine& line : simulation_.health()) lines.emplace_back(line.name, line.text, line.is_good, line.remedy);
    return lines;
  }
  const std::vector<std::string>& history_names() const { return history_names_; }
  const std::vector<std::string>& history_units() const { return history_units_; }

  std::vector<std::string> body_names() const {
    std::vector<std::string> names;
    for (std::size_t b = 0; b < solver().body_count(); ++b) names.push_back(solver().body_name(b));
    return names;
  }
  /// Keeps the interpreter's lock: nothing may step meanwhile.
  Array field(std::size_t body, const std::string& name) const {
    require_between_steps();
    return make_array(solver().field(body, name));
  }
  /// VTK's type of the cells of a body of elements, nodes per cell, nodes of all cells; nothing for particles.
  std::tuple<int, Index, std::vector<Index>> cells(std::size_t body) const {
    const BodyCells* const cells = solver().cells(body);
    if (cells == nullptr) return {0, 0, {}};
    return {cells->vtk_type, cells->nodes_per_cell, cells->nodes};
  }
  Array node_field(std::size_t body, const std::string& name) const {
    require_between_steps();
    return make_array(solver().node_field(body, name));
  }
  void set_field(std::size_t body, const std::string& name, ConstArray values) {
    require_between_steps();
    simulation_.set_field(body, name, {values.data(), values.data() + values.size()});
  }
  nb::typed<nb::dict, nb::str, Array> grid_fields() const {
    require_between_steps();
    nb::typed<nb::dict, nb::str, Array> fields;
    for (Field& field : solver().grid_fields()) {
      const std::string name = field.name;
      fields[nb::str(name.c_str())] = make_array(std::move(field));
    }
    return fields;
  }

  /// With the history that was recorded.
  void save(const std::string& path) {
    require_between_steps();
    write_state(path, state_now());
  }
  void load(const std::string& path) {
    require_idle();
    const FoundState found = find_state(path);
    check_same_case(found, simulation_.problem());
    load_from(found.table);
  }
  void copy_state(PythonSimulation& other) {
    other.require_between_steps();
    load_from(other.state_now());
  }

  Table resolved() const { return nb::borrow<Table>(from_input(simulation_.problem().to_input())); }

  std::vector<std::string> warnings() const {
    require_between_steps();
    return simulation_.warnings();
  }
  Real next_dt() const {
    require_between_steps();
    return simulation_.next_dt();
  }
  Index memory() const {
    require_between_steps();
    return solver().memory();
  }
  Index particle_count(std::size_t body) const {
    require_between_steps();
    return solver().particle_count(body);
  }

 private:
  StateTable state_now() {
    StateTable table = simulation_.save_state();
    std::vector<Real>& all = std::get<std::vector<Real>>(table.emplace(k_rows, std::vector<Real>{}).first->second);
    for (const std::vector<Real>& row : rows_) all.insert(all.end(), row.begin(), row.end());
    return table;
  }
  void load_from(const StateTable& table) {
    simulation_.load_state(table);
    rows_.clear();
    const auto found = table.find(k_rows);  // a checkpoint of a run has its rows in history.csv
    const auto* const all = found == table.end() ? nullptr : std::get_if<std::vector<Real>>(&found->second);
    const auto width = static_cast<std::ptrdiff_t>(history_names_.size());
    for (std::ptrdiff_t row = 0; all != nullptr && row + width <= static_cast<std::ptrdiff_t>(all->size()); row += width)
      rows_.emplace_back(all->begin() + row, all->begin() + row + width);
  }
  static constexpr const char* k_rows = "history/rows";

  /// While it exists the simulation goes on, in this thread.
  class Running {
   public:
    explicit Running(PythonSimulation& simulation) : simulation_(simulation) {
      simulation_.interrupt_ = 0;
      simulation_.signal_.reset();
      take_interrupt();
      simulation_.runner_ = std::this_thread::get_id();
      simulation_.is_running_ = true;
      const std::lock_guard lock(g_running_mutex);
      g_running.insert(&simulation_.interrupt_);
    }
    ~Running() {
      const std::lock_guard lock(g_running_mutex);
      g_running.erase(&simulation_.interrupt_);
      simulation_.is_running_ = simulation_.is_in_callback_ = false;
    }
    Running(const Running&) = delete;
    Running& operator=(const Running&) = delete;

   private:
    PythonSimulation& simulation_;
  };

  void require_idle() const {
    if (!is_running_) return;
    throw InputError(
        "the simulation is running; run, step and a results folder must wait until that is done, also in callbacks and functions of the "
        "case");
  }
  /// For whatever reads or changes the state: not in the middle of a step, whose stages it would meet.
  void require_between_steps() const {
    if (!is_running_ || (is_in_callback_ && runner_ == std::this_thread::get_id())) return;
    throw InputError("the simulation is in the middle of a step; read and change it between runs, or in a callback (every)");
  }
  bool call(const nb::object& function) {
    try {
      return nb::cast<bool>(function());
    } catch (const nb::python_error& error) {
      // Ctrl-C met the function and not the core: the run ends as it would have.
      if (!error.matches(PyExc_KeyboardInterrupt)) throw;
      interrupt_with(error);
      return true;
    }
  }
  /// Ctrl-C, at most twenty times a second.
  void look_for_signals() {
    const Clock::time_point now = Clock::now();
    if (std::chrono::duration<double>(now - looked_).count() < 0.05) return;
    looked_ = now;
    if (!nb::is_alive()) {  // a thread that outlives the interpreter
      interrupt_ = 1;
      return;
    }
    const nb::gil_scoped_acquire lock;
    if (take_interrupt()) PyErr_SetNone(PyExc_KeyboardInterrupt);
    if (PyErr_Occurred() == nullptr && PyErr_CheckSignals() == 0) return;
    interrupt_with(nb::python_error());
  }
  void interrupt_with(const nb::python_error& error) {
    signal_ = std::make_unique<nb::python_error>(error);
    interrupt_ = 1;
  }
  void raise_signal() {
    if (!signal_) return;
    const std::unique_ptr<nb::python_error> error = std::move(signal_);
    throw nb::python_error(*error);
  }

  Simulation simulation_;
  std::unique_ptr<ResultsFolder> results_;
  std::vector<std::string> history_names_;
  std::vector<std::string> history_units_;
  std::vector<std::vector<Real>> rows_;
  std::atomic<int> interrupt_{0};
  std::unique_ptr<nb::python_error> signal_;
  Clock::time_point looked_ = Clock::now();
  std::atomic<bool> is_running_{false};
  std::atomic<bool> is_in_callback_{false};
  std::thread::id runner_;
};

}  // namespace

void bind_simulation(nb::module_& m) {
  m.def("end_runs", &end_runs, "Ends all runs in other threads after their step, and comes back then.");
  m.def(
      "case_of_state",
      [](const std::string& path, bool is_given) {
        const FoundState found = find_state(path);
        if (is_given) return nb::make_tuple(std::string(), nb::dict());
        const auto [input, name] = saved_case(found);
        return nb::make_tuple(name, from_input(input));
      },
      nb::arg("path"), nb::arg("is_given"), nb::sig("def case_of_state(path: str, is_given: bool) -> tuple[str, dict[str, typing.Any]]"));
  using S = PythonSimulation;
  nb::class_<S>(m, "Simulation", "The core's simulation.")
      .def(nb::init<nb::handle, const std::string&>(), nb::arg("data"), nb::arg("name"))
      .def("open_results", &S::open_results, nb::arg("folder"), nb::arg("overwrite"), nb::arg("command"))
      .def("has_results", &S::has_results)
      .def("run", &S::run, nb::arg("until").none())
      .def("step", &S::step, nb::arg("count"))
      .def("add_callback", &S::add_callback, nb::arg("function"), nb::arg("every_steps"), nb::arg("every_time"), nb::arg("every_wall"))
      .def("history", &S::history)
      .def("boundaries", &S::boundaries)
      .def("health", &S::health)
      .def("record", &S::record_now)
      .def("history_names", &S::history_names)
      .def("history_units", &S::history_units)
      .def("body_names", &S::body_names)
      .def("particle_count", &S::particle_count, nb::arg("body"))
      .def(
          "field_names", [](const S& s, std::size_t body) { return s.solver().field_names(body); }, nb::arg("body"))
      .def("field", &S::field, nb::arg("body"), nb::arg("name"))
      .def("set_field", &S::set_field, nb::arg("body"), nb::arg("name"), nb::arg("values"))
      .def("cells", &S::cells, nb::arg("body"))
      .def(
          "node_field_names", [](const S& s, std::size_t body) { return s.solver().node_field_names(body); }, nb::arg("body"))
      .def("node_field", &S::node_field, nb::arg("body"), nb::arg("name"))
      .def("grid_fields", &S::grid_fields)
      .def("save", &S::save, nb::arg("path"))
      .def("load", &S::load, nb::arg("path"))
      .def("copy_state", &S::copy_state, nb::arg("other"))
      .def("resolved", &S::resolved)
      .def("warnings", &S::warnings)
      .def("time", [](const S& s) { return s.simulation().time(); })
      .def("step_count", [](const S& s) { return s.simulation().step_count(); })
      .def("last_dt", [](const S& s) { return s.simulation().last_dt(); })
      .def("next_dt", &S::next_dt)
      .def("node_count", [](const S& s) { return s.solver().node_count(); })
      .def("memory", &S::memory);
}

}  // namespace matpoint::python
