#include "io/results_folder.hpp"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <limits>
#include <set>
#include <utility>

#include "io/state_file.hpp"

namespace matpoint {
namespace {

namespace fs = std::filesystem;

constexpr const char* k_manifest = "manifest.toml";
constexpr const char* k_checkpoints = "checkpoints";

std::string probe_file(const ProbeSpec& probe) { return "probe_" + probe.name + ".csv"; }

bool has(const std::vector<std::string>& list, const std::string& name) { return std::find(list.begin(), list.end(), name) != list.end(); }

/// Names of bodies and probes become file names and columns of a CSV file.
void check_file_name(const std::string& what, const std::string& name, const std::string& place) {
  const auto is_allowed = [](char c) {
    const auto u = static_cast<unsigned char>(c);
    return std::isalnum(u) != 0 || u >= 0x80 || std::string_view("_-+. ").find(c) != std::string_view::npos;
  };
  if (!name.empty() && name.size() <= 100 && name[0] != '.' && std::all_of(name.begin(), name.end(), is_allowed)) return;
  throw InputError(
      "{}{} \"{}\": its results cannot be named so; allowed: 1 to 100 letters, digits, spaces or any of _ - + . but not a . first",
      place.empty() ? "" : place + ": ", what, printable(name));
}

void check_file_names(const Case& problem) {
  std::set<std::string> taken;
  if (problem.output.grid) taken.insert("grid");
  for (const BodySpec& body : problem.bodies) {
    check_file_name("body", body.name, body.place);
    if (!taken.insert(body.name).second) {
      throw InputError("{}body \"{}\": its files would have the names of {}; rename the body", body.place.empty() ? "" : body.place + ": ",
                       body.name, body.name == "grid" ? "the grid's" : "another body's");
    }
  }
  taken.clear();
  for (const ProbeSpec& probe : problem.probes) {
    check_file_name("probe", probe.name, probe.place);
    if (!taken.insert(probe.name).second) {
      throw InputError("{}probe \"{}\": another probe has this name; rename one", probe.place.empty() ? "" : probe.place + ": ",
                       probe.name);
    }
  }
}

/// Whether `name` is `pattern` with digits for its `*`, or the temporary file of such a name.
bool matches(const std::string& name, const std::string& pattern) {
  const std::string full = name.ends_with(".tmp") ? name.substr(0, name.size() - 4) : name;
  const std::size_t star = pattern.find('*');
  if (star == std::string::npos) return full == pattern;
  const std::string_view tail = std::string_view(pattern).substr(star + 1);
  if (full.size() <= star + tail.size() || !full.starts_with(pattern.substr(0, star)) || !full.ends_with(tail)) return false;
  const std::string_view digits = std::string_view(full).substr(star, full.size() - star - tail.size());
  return std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; });
}

void add_units(Input& table, const std::vector<HistoryColumn>& columns) {
  for (const HistoryColumn& column : columns) {
    // A body's columns have the units of the totals.
    if (column.name.find('.') == std::string::npos) table.set(column.name, Input::string(column.unit));
  }
}

/// What a body's file shows: fields of its particles, or of its nodes where it consists of finite elements.
std::vector<std::string> written_names(const Solver& solver, std::size_t body) {
  return solver.cells(body) != nullptr ? solver.node_field_names(body) : solver.field_names(body);
}

std::string unit_of(const Solver& solver, std::size_t body, const std::string& name) {
  return (solver.cells(body) != nullptr ? solver.node_field(body, name) : solver.field(body, name)).unit;
}

/// Takes the positions and the named fields of a body; what `set` holds from an earlier time lends its memory.
void take_fields(const Snapshot& now, std::size_t body, const std::vector<std::string>& names, FieldSet& set) {
  set.time = now.time;
  set.cells = now.solver.cells(body);
  std::vector<std::string> all = {"position"};
  all.insert(all.end(), names.begin(), names.end());
  set.fields.insert(set.fields.begin(), Field{"position", "m", 3, std::move(set.position)});
  if (set.cells == nullptr) {
    now.solver.take_fields(body, all, 3, set.fields);
  } else {
    set.fields.clear();
    for (const std::string& name : all) set.fields.push_back(pad_vector(now.solver.node_field(body, name)));
  }
  set.position = std::move(set.fields.front().values);
  set.fields.erase(set.fields.begin());
}

void check_fields(const Case& problem, const Solver& solver) {
  std::vector<std::string> known;
  for (std::size_t b = 0; b < solver.body_count(); ++b) {
    for (const std::string& name : written_names(solver, b)) {
      if (!has(known, name)) known.push_back(name);
    }
  }
  if (!has(known, "displacement")) known.push_back("displacement");
  for (const std::string& name : problem.output.fields) {
    if (has(known, name)) continue;
    throw InputError("output: fields: \"{}\" is unknown, allowed: {}{}", printable(name), list_names(known), did_you_mean(name, known));
  }
}

/// Whether single precision would round positions by a good part of the distance of two particles: a grid in map coordinates.
bool is_far_away(const Solver& solver) {
  constexpr Real k_single = 6e-8;  // half a unit in the last place
  constexpr Real k_share = 2e-4;   // of a cell
  const GridGeometry& grid = solver.grid();
  Real farthest = 0, shortest = std::numeric_limits<Real>::infinity();
  for (std::size_t d = 0; d < static_cast<std::size_t>(solver.dim()); ++d) {
    const Real upper = grid.lower[d] + grid.cell_size[d] * (grid.nodes[d] - 1);
    farthest = std::max({farthest, std::abs(grid.lower[d]), std::abs(upper)});
    shortest = std::min(shortest, grid.cell_size[d]);
  }
  return farthest * k_single > k_share * shortest;
}

std::string checkpoint_name(Index step) { return fmt::format("step_{:012}.h5", step); }

}  // namespace

bool is_written_on_request(const std::string& name) {
  return has({"density", "principal_stress", "stress_ratio", "equivalent_strain"}, name);
}

std::vector<fs::path> checkpoints_of(const fs::path& folder) {
  std::vector<fs::path> all;
  std::error_code error;
  for (const fs::directory_entry& file : fs::directory_iterator(folder / k_checkpoints, error)) {
    if (matches(file.path().filename().string(), "step_*.h5") && file.path().extension() != ".tmp") all.push_back(file.path());
  }
  std::sort(all.begin(), all.end());
  return all;
}

void check_outputs(const Case& problem, const Solver& solver) {
  check_file_names(problem);
  check_fields(problem, solver);
  for (const ProbeSpec& probe : problem.probes) find_probe(probe, solver);
}

ResultsFolder::ResultsFolder(fs::path path, ExistingFolder existing) : path_(std::move(path)), existing_(existing) { check_folder(); }

void ResultsFolder::check_folder() const {
  std::error_code error;
  const fs::file_status status = fs::status(path_, error);
  if (status.type() == fs::file_type::not_found) return;
  if (status.type() != fs::file_type::directory) {
    throw InputError("cannot create results folder \"{}\": {}", path_.string(), error ? error.message() : "there is a file of that name");
  }
  bool is_empty = true;
  for (const fs::directory_entry& entry : fs::directory_iterator(path_, error)) {
    // What a run leaves that ends before its manifest is there.
    const fs::path name = entry.path().filename();
    is_empty = is_empty && (name == k_lock_name || name == std::string(k_manifest) + ".tmp");
  }
  if (error) throw InputError("cannot create results folder \"{}\": {}", path_.string(), error.message());
  if (is_empty) return;
  if (existing_ == ExistingFolder::refuse) {
    throw InputError(
        "results folder \"{}\" exists and is not empty; give --overwrite (overwrite=True) to replace it, or another folder with --out "
        "(output=...)",
        path_.string());
  }
  if (!fs::exists(path_ / k_manifest, error)) {
    throw InputError(
        "results folder \"{}\" holds files but no {}, so no run of matpoint wrote it and nothing in it is deleted; give another "
        "folder with --out",
        path_.string(), k_manifest);
  }
  manifest_files(path_ / k_manifest);
}

void ResultsFolder::describe(const Snapshot& now, int threads, const std::string& command) {
  const Case& problem = now.problem;
  check_outputs(problem, now.solver);
  manifest_.threads = threads;
  manifest_.command = command;
  manifest_.started = time_stamp();
  manifest_.case_input = problem.to_input();
  manifest_.history_units = Input::table();
  add_units(manifest_.history_units, history_columns(now.solver));
  add_units(manifest_.history_units, probe_columns(now.solver.dim()));
  choose_fields(now);
  list_files(now);
}

void ResultsFolder::begin(const Snapshot& start, int threads, const std::string& command) {
  describe(start, threads, command);
  for (const ProbeSpec& probe : start.problem.probes) targets_.push_back(find_probe(probe, start.solver));
  check_folder();
  try {
    fs::create_directories(path_);
    lock_.take(path_, manifest_.started);
    delete_earlier_run();
    probe_specs_ = start.problem.probes;
    write_manifest(start);  // first: without it nobody may replace what is in the folder
    make_folder();
    history_.emplace(path_ / "history.csv", start.solver);
    for (std::size_t i = 0; i < targets_.size(); ++i)
      probes_.push_back(std::make_unique<Probe>(path_ / probe_file(start.problem.probes[i]), targets_[i], start.solver.dim()));
    make_writers(start);
  } catch (const SolverError& error) {
    // Nothing has run yet: a folder that cannot be written is a wrong --out, not a failed run.
    throw InputError("cannot create results folder \"{}\": {}", path_.string(), error.what());
  } catch (const fs::filesystem_error& error) {
    throw InputError("cannot create results folder \"{}\": {}", path_.string(), error.code().message());
  }
}

void ResultsFolder::begin_again(const Snapshot& now, const StateTable& checkpoint, int threads, const std::string& command) {
  describe(now, threads, command);
  lock_.take(path_, manifest_.started);
  make_writers(now);
  State state = State::loading(checkpoint);
  state.in("results", [&] { declare_state(state); });
  for (const Writers& writers : bodies_) writers.take_back();
  grid_.take_back();
  taken_step_ = fields_step_;
  write_manifest(now);
}

void ResultsFolder::declare_state(State& state) {
  std::string started = manifest_.started;
  state.add("started", started);
  manifest_.started = started;
  state.rows("probe", targets_);
  Index history_size = history_ ? history_->file().size() : 0;
  state.add("history_size", history_size);
  std::vector<Index> probe_sizes;
  for (const auto& probe : probes_) probe_sizes.push_back(probe->file().size());
  state.add("probe_sizes", probe_sizes);
  state.add("history_step", history_step_);
  state.add("history_time", history_time_);
  state.add("fields_step", fields_step_);
  state.add("fields_time", fields_time_);
  state.parts("body", bodies_);
  state.part("grid", grid_);
  if (!state.is_loading()) return;
  const std::vector<ProbeSpec>& probes = probe_specs_;
  if (probe_sizes.size() != probes.size() || targets_.size() != probes.size()) state.fail("probe", "has not one row for each probe");
  history_.emplace(path_ / "history.csv", history_size);
  for (std::size_t i = 0; i < probes.size(); ++i)
    probes_.push_back(std::make_unique<Probe>(path_ / probe_file(probes[i]), targets_[i], probe_sizes[i]));
}

void ResultsFolder::choose_fields(const Snapshot& start) {
  const std::vector<std::string>& wanted = start.problem.output.fields;
  manifest_.field_units = Input::table();
  for (std::size_t b = 0; b < start.solver.body_count(); ++b) {
    Writers& writers = bodies_.emplace_back();
    for (const std::string& name : written_names(start.solver, b)) {
      // The points' coordinates are always written.
      if (name != "position" && (wanted.empty() ? !is_written_on_request(name) : has(wanted, name))) {
        writers.fields.push_back(name);
        manifest_.field_units.set(name, Input::string(unit_of(start.solver, b, name)));
      }
    }
  }
}

void ResultsFolder::list_files(const Snapshot& start) {
  const OutputSpec& output = start.problem.output;
  manifest_.files = {k_manifest, "history.csv", std::string(k_checkpoints) + "/step_*.h5"};
  for (const ProbeSpec& probe : start.problem.probes) manifest_.files.push_back(probe_file(probe));
  const auto add = [&](const std::string& name, const std::string& extension) {
    if (has(output.formats, "vtkhdf")) {
      manifest_.files.push_back(name + ".vtkhdf");
      manifest_.files.push_back("vtkhdf/" + name + "_*.h5");
    }
    if (has(output.formats, "vtu")) {
      manifest_.files.push_back(name + ".pvd");
      manifest_.files.push_back("vtu/" + name + "_*" + extension);
    }
  };
  for (std::size_t b = 0; b < start.solver.body_count(); ++b) add(start.solver.body_name(b), ".vtu");
  if (output.grid) add("grid", ".vti");
}

void ResultsFolder::delete_earlier_run() const {
  if (!fs::exists(path_ / k_manifest)) return;
  std::set<fs::path> folders;
  for (const std::string& entry : manifest_files(path_ / k_manifest)) {
    const fs::path pattern(entry);
    // Whatever has become of the manifest: nothing outside the folder is deleted. The manifest itself goes last, so that an
    // interrupted deletion can be taken up again.
    if (entry == k_manifest || pattern.is_absolute() || has({pattern.begin(), pattern.end()}, "..")) continue;
    const fs::path folder = path_ / pattern.parent_path();
    if (!fs::is_directory(folder)) continue;
    std::vector<fs::path> found;
    for (const fs::directory_entry& file : fs::directory_iterator(folder)) {
      if (!file.is_directory() && matches(file.path().filename().string(), pattern.filename().string())) found.push_back(file.path());
    }
    for (const fs::path& file : found) fs::remove(file);
    if (pattern.has_parent_path()) folders.insert(folder);
  }
  for (const fs::path& folder : folders) {
    if (fs::is_empty(folder)) fs::remove(folder);
  }
  fs::remove(path_ / k_manifest);
}

void ResultsFolder::make_folder() const {
  for (const std::string& file : manifest_.files) {
    const fs::path folder = fs::path(file).parent_path();
    if (!folder.empty() && folder != k_checkpoints) fs::create_directories(path_ / folder);
  }
}

void ResultsFolder::make_writers(const Snapshot& start) {
  watch_.emplace(path_);
  const OutputSpec& output = start.problem.output;
  const Number real = output.precision == "double" || is_far_away(start.solver) ? Number::float64 : Number::float32;
  const bool has_hdf = has(output.formats, "vtkhdf");
  const bool has_vtu = has(output.formats, "vtu");
  probe_specs_ = start.problem.probes;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const std::string& name = start.solver.body_name(b);
    if (has_hdf) bodies_[b].hdf.emplace(path_, name, real, output.compression);
    if (has_vtu) bodies_[b].vtu.emplace(path_, name, real);
  }
  if (output.grid && has_hdf) grid_.hdf.emplace(path_, "grid", real, output.compression, start.solver.grid(), start.solver.dim());
  if (output.grid && has_vtu) grid_.vtu.emplace(path_, "grid", real, start.solver.grid());
}

HistoryRecord ResultsFolder::record(const Snapshot& now) const {
  HistoryRecord record{now.step, history_row(now), {}};
  for (const auto& probe : probes_) record.probes.push_back(probe->row(now));
  return record;
}

void ResultsFolder::write_history(const HistoryRecord& record) {
  if (history_step_ >= 0 && record.time() <= history_time_) return;
  // A disk that is full ends the run soon, and not when the next fields are due.
  if (writing_.valid() && writing_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) wait();
  history_->write(record.history);
  for (std::size_t p = 0; p < probes_.size(); ++p) probes_[p]->write(record.probes[p]);
  history_step_ = record.step;
  history_time_ = record.time();
}

void ResultsFolder::write_fields(const Snapshot& now) {
  if (taken_step_ == now.step) return;
  wait();  // first: the fields of two times would need twice the memory
  fields_.step = now.step;
  fields_.time = now.time;
  fields_.particles.resize(bodies_.size());
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (bodies_[b].hdf || bodies_[b].vtu) take_fields(now, b, bodies_[b].fields, fields_.particles[b]);
  }
  if (grid_.hdf || grid_.vtu) {
    fields_.nodes.emplace(FieldSet{now.time, {}, {}, nullptr});
    for (Field& field : now.solver.grid_fields()) fields_.nodes->fields.push_back(pad_vector(std::move(field)));
  }
  taken_step_ = now.step;
  writing_ = std::async(std::launch::async, [this] { append(fields_); });
}

void ResultsFolder::append(const Fields& fields) {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (bodies_[b].hdf) bodies_[b].hdf->write(fields.particles[b], &*watch_);
    if (bodies_[b].vtu) bodies_[b].vtu->write(fields.particles[b]);
  }
  if (grid_.hdf) grid_.hdf->write(*fields.nodes, &*watch_);
  if (grid_.vtu) grid_.vtu->write(*fields.nodes);
  fields_step_ = fields.step;
  fields_time_ = fields.time;
}

void ResultsFolder::write_checkpoint(const Snapshot& now, StateTable state) {
  wait();
  State results = State::saving(state);
  results.in("results", [&] { declare_state(results); });
  state_ = std::make_shared<StateTable>(std::move(state));
  const Index step = now.step;
  writing_ = std::async(std::launch::async, [this, table = state_, step] {
    const fs::path folder = path_ / k_checkpoints;
    std::error_code ignored;
    fs::create_directories(folder, ignored);
    // What the checkpoint counts on is on the disk before it is there.
    sync_rows();
    write_state(folder / checkpoint_name(step), *table);
    const std::vector<fs::path> all = checkpoints_of(path_);
    for (std::size_t k = 0; k + 2 < all.size(); ++k) fs::remove(all[k], ignored);
  });
}

StateTable ResultsFolder::spare_state() {
  wait();
  return state_ ? std::move(*std::exchange(state_, nullptr)) : StateTable{};
}

ResultsFolder::Mark ResultsFolder::mark() {
  Mark mark{history_->file().size(), {}, history_step_, history_time_, taken_step_};
  for (const auto& probe : probes_) mark.probe_sizes.push_back(probe->file().size());
  return mark;
}

void ResultsFolder::take_back(const Mark& mark, const Snapshot& now, const std::function<StateTable()>& state) {
  wait();
  history_->file().cut(mark.history_size);
  for (std::size_t p = 0; p < probes_.size(); ++p) probes_[p]->file().cut(mark.probe_sizes[p]);
  history_step_ = mark.history_step;
  history_time_ = mark.history_time;
  if (fields_step_ != mark.fields_step) {
    for (Writers* writers : all_writers()) writers->drop_after(now.time);
    fields_step_ = taken_step_ = mark.fields_step;
    fields_time_ = now.time;
  }
  const std::vector<fs::path> all = checkpoints_of(path_);
  const std::string last = checkpoint_name(now.step);
  if (all.empty() || all.back().filename() <= last) return;
  // The newest goes last: there is one at any time.
  for (std::size_t k = 0; k + 1 < all.size(); ++k) {
    if (all[k].filename() > last) fs::remove(all[k]);
  }
  write_checkpoint(now, state());
  wait();
  fs::remove(all.back());
}

std::vector<ResultsFolder::Writers*> ResultsFolder::all_writers() {
  std::vector<Writers*> all{&grid_};
  for (Writers& writers : bodies_) all.push_back(&writers);
  return all;
}

void ResultsFolder::sync_rows() {
  history_->file().sync();
  for (const auto& probe : probes_) probe->file().sync();
}

void ResultsFolder::wait() {
  if (!writing_.valid()) return;
  try {
    writing_.get();
  } catch (...) {
    taken_step_ = fields_step_;  // these fields may be tried again
    throw;
  }
}

void ResultsFolder::resume(const Snapshot& now) {
  lock_.take(path_, manifest_.started);
  manifest_.status = "running";
  manifest_.message.clear();
  manifest_.ended.clear();
  write_manifest(now);
}

void ResultsFolder::finish(const Snapshot& end, const std::string& status) {
  wait();
  for (Writers* writers : all_writers()) {
    if (writers->hdf) writers->hdf->settle(*watch_);
  }
  sync_rows();
  manifest_.status = status;
  manifest_.ended = time_stamp();
  write_manifest(end);
  lock_.release();
}

void ResultsFolder::fail(const Snapshot& end, const std::string& message) noexcept {
  try {
    if (writing_.valid()) writing_.wait();  // what can still be written
    writing_ = {};                          // the caller has an error to report already
    manifest_.message = message;
    finish(end, "failed");
  } catch (const std::exception&) {
    // The manifest of the start stays, with status = "running".
  }
}

std::string ResultsFolder::last_written() const {
  if (writing_.valid()) writing_.wait();
  if (history_step_ < 0 && fields_step_ < 0) return fmt::format("nothing in {}", path_.string());
  const auto part = [](const char* what, Index step, Real time) {
    return step < 0 ? fmt::format("no {}", what) : fmt::format("{} at t = {:.8g} s", what, time);
  };
  const std::vector<fs::path> states = checkpoints_of(path_);
  const std::string state = states.empty() ? "" : fmt::format(", {}", (fs::path(k_checkpoints) / states.back().filename()).string());
  return fmt::format("{}, {}{} in {}", part("history", history_step_, history_time_), part("fields", fields_step_, fields_time_), state,
                     path_.string());
}

void ResultsFolder::write_manifest(const Snapshot& now) {
  manifest_.probes.clear();
  for (std::size_t i = 0; i < targets_.size(); ++i)
    manifest_.probes.push_back(fmt::format("{}: particle {} of {}", probe_specs_[i].name, targets_[i].particle, probe_specs_[i].body));
  write_file(path_ / k_manifest, manifest_text(manifest_, now));
}

}  // namespace matpoint
