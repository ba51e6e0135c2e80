// The results of one run in one folder (docs/case_file.md describes the files):
//
//   manifest.toml                            resolved case, version, commit, threads, state of the run
//   history.csv, probe_<name>.csv            a row per history interval
//   <body>.vtkhdf + vtkhdf/<body>_*.h5       fields of all times, formats = ["vtkhdf"]; of the grid grid.vtkhdf
//   <body>.pvd + vtu/<body>_*.vtu            the same for older ParaView, formats = ["vtu"]; the grid as grid.pvd + vtu/grid_*.vti
//   checkpoints/step_*.h5                    the last two states, from which the run can go on
//   .lock                                    held by the process that writes
//
// Rows of text are on their way to the disk when a call returns, fields and checkpoints follow beside the run (`wait`). A run that is
// killed or fails leaves readable files (docs/states.md says what is promised).
#pragma once

#include <functional>
#include <future>
#include <memory>
#include <optional>

#include "io/folder_lock.hpp"
#include "io/manifest.hpp"
#include "io/probe.hpp"
#include "io/vtkhdf.hpp"
#include "io/vtu.hpp"

namespace matpoint {

/// Whether the outputs that a case asks for can be written: names of files, fields, probes. Throws InputError.
void check_outputs(const Case& problem, const Solver& solver);

/// Whether a field that every body has is written only where `output.fields` names it: it follows from others, and costs more time and
/// room than it is worth in every run.
bool is_written_on_request(const std::string& name);

/// The complete checkpoints of a results folder, the oldest first.
std::vector<std::filesystem::path> checkpoints_of(const std::filesystem::path& folder);

enum class ExistingFolder { refuse, overwrite };

class ResultsFolder {
 public:
  /// Checks that the folder may be used, and touches nothing. Throws InputError: not a folder; not empty and `refuse`; with
  /// `overwrite`, a folder with files that is not an earlier run's.
  explicit ResultsFolder(std::filesystem::path path, ExistingFolder existing = ExistingFolder::refuse);

  const std::filesystem::path& path() const { return path_; }

  /// Resolves probes and fields, makes the folder (with `overwrite`, deletes what the earlier run wrote and nothing else), and writes
  /// the manifest with status = "running". Throws InputError.
  void begin(const Snapshot& start, int threads, const std::string& command = "");

  /// The same for a run that goes on from one of the folder's checkpoints: what was written after it is taken back. Throws InputError where
  /// the files are not those of the checkpoint.
  void begin_again(const Snapshot& now, const StateTable& checkpoint, int threads, const std::string& command = "");

  /// What write_history writes, of now.
  HistoryRecord record(const Snapshot& now) const;

  /// Appends to the history and the probes; does nothing if this time is there already. Throws SolverError.
  void write_history(const HistoryRecord& record);
  void write_history(const Snapshot& now) { write_history(record(now)); }

  /// Takes the fields and appends them to the files beside the run, which may go on; waits for the fields before these. Does nothing if
  /// this step is there already. Throws SolverError, also for what went wrong with earlier fields.
  void write_fields(const Snapshot& now);

  /// Writes a checkpoint beside the run, after the fields before it, and keeps the last two. `state`: of the simulation. Throws SolverError
  /// for what went wrong with earlier fields.
  void write_checkpoint(const Snapshot& now, StateTable state);
  /// The state of the last checkpoint, to use its memory; waits for what is being written. Throws SolverError.
  StateTable spare_state();

  /// How far the files are, to come back to.
  struct Mark {
    Index history_size = 0;
    std::vector<Index> probe_sizes;
    Index history_step = -1;
    Real history_time = 0;
    Index fields_step = -1;
  };
  Mark mark();
  /// The run is back where it was at `mark`, at the time `now`: what was written since is taken back. Where there are checkpoints of what
  /// came after, one of now, of what `state` gives, replaces them. Throws SolverError.
  void take_back(const Mark& mark, const Snapshot& now, const std::function<StateTable()>& state);

  /// Comes back when all fields and checkpoints are in the files. Throws SolverError.
  void wait();

  /// The manifest again with status = "running", for a run that goes on after it ended. Throws SolverError.
  void resume(const Snapshot& now);

  /// Rewrites the manifest with the way the run ended: "finished", "interrupted", ... Throws SolverError.
  void finish(const Snapshot& end, const std::string& status);

  /// The same with status = "failed" and the message. Never throws: the failure may be that nothing can be written, and the caller has
  /// an error to report.
  void fail(const Snapshot& end, const std::string& message) noexcept;

  /// "history at t = 0.5 s, fields at t = 0.4 s in results/disks", for messages.
  std::string last_written() const;

 private:
  struct Writers {
    std::vector<std::string> fields;
    std::optional<VtkHdfSeries> hdf;
    std::optional<VtuSeries> vtu;
    void declare_state(State& state) {
      if (hdf) state.part("vtkhdf", *hdf);
      if (vtu) state.part("vtu", *vtu);
    }
    void take_back() const {
      if (hdf) hdf->take_back();
      if (vtu) vtu->take_back();
    }
    void drop_after(Real time) {
      if (hdf) hdf->drop_after(time);
      if (vtu) vtu->drop_after(time);
      take_back();
    }
  };

  void check_folder() const;
  void choose_fields(const Snapshot& start);
  void list_files(const Snapshot& start);
  void delete_earlier_run() const;
  void make_folder() const;
  void describe(const Snapshot& now, int threads, const std::string& command);
  void make_writers(const Snapshot& start);
  /// What has been written; the files are as long as that.
  void declare_state(State& state);
  void write_manifest(const Snapshot& now);
  /// All fields of one time.
  struct Fields {
    Index step = 0;
    Real time = 0;
    std::vector<FieldSet> particles;  ///< Per body.
    std::optional<FieldSet> nodes;
  };
  void append(const Fields& fields);
  void sync_rows();
  std::vector<Writers*> all_writers();

  std::filesystem::path path_;
  ExistingFolder existing_;
  FolderLock lock_;
  Manifest manifest_;
  std::optional<History> history_;
  std::vector<ProbeSpec> probe_specs_;
  std::vector<ProbeTarget> targets_;
  std::vector<std::unique_ptr<Probe>> probes_;
  std::optional<ReaderWatch> watch_;  ///< From begin() on.
  std::vector<Writers> bodies_;
  Writers grid_;
  Index history_step_ = -1;
  Index fields_step_ = -1;
  Real history_time_ = 0;
  Real fields_time_ = 0;
  Index taken_step_ = -1;              ///< Of the fields that are in the files or on their way there.
  Fields fields_;                      ///< Of the last time that was taken; the next one uses its memory.
  std::shared_ptr<StateTable> state_;  ///< Of the last checkpoint; the next one uses its memory.
  std::future<void> writing_;          // last: what it writes with must outlive it
};

}  // namespace matpoint
