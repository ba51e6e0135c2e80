#include "implicit/petsc_solver.hpp"

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <thread>

#include "core/error.hpp"
#include "implicit/petsc_system.hpp"

namespace matpoint {
namespace {

/// What the first rank has the others do.
enum class Task : int { make, analyze, factorize, solve, release, end };
constexpr int k_task_tag = 1;
constexpr int k_data_tag = 2;

MPI_Datatype type_of(const PetscInt*) { return MPIU_INT; }
MPI_Datatype type_of(const Real*) { return MPI_DOUBLE; }
MPI_Datatype type_of(const char*) { return MPI_CHAR; }

template <class T>
void send(int rank, const T* values, std::size_t count) {
  MPI_Send(values, static_cast<int>(count), type_of(values), rank, k_data_tag, MPI_COMM_WORLD);
}
template <class Values>
void receive(int rank, Values& values) {
  MPI_Status status;
  MPI_Probe(rank, k_data_tag, MPI_COMM_WORLD, &status);
  int count = 0;
  MPI_Get_count(&status, type_of(values.data()), &count);
  values.resize(static_cast<std::size_t>(count));
  MPI_Recv(values.data(), count, type_of(values.data()), rank, k_data_tag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
}

/// The ranks that mpirun has started; one where it has not.
class Ranks {
 public:
  static Ranks& get() {
    static Ranks one;
    return one;
  }
  ~Ranks() {
    if (rank_ == 0) tell(Task::end);
  }
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;
  int count() const { return count_; }
  int rank() const { return rank_; }
  MPI_Comm comm() const { return count_ > 1 ? MPI_COMM_WORLD : MPI_COMM_SELF; }

  void join() {
    start_petsc();
    MPI_Comm_size(MPI_COMM_WORLD, &count_);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  }
  void tell(Task task, int detail = 0) const {
    const int message[2] = {static_cast<int>(task), detail};
    for (int other = 1; other < count_; ++other) MPI_Send(message, 2, MPI_INT, other, k_task_tag, MPI_COMM_WORLD);
  }
  /// The next task, which may be long in coming: without keeping a processor busy meanwhile.
  std::pair<Task, int> wait() const {
    for (int there = 0;;) {
      MPI_Iprobe(0, k_task_tag, MPI_COMM_WORLD, &there, MPI_STATUS_IGNORE);
      if (there != 0) break;
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
    int message[2];
    MPI_Recv(message, 2, MPI_INT, 0, k_task_tag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    return {static_cast<Task>(message[0]), message[1]};
  }
  /// f(), whose failure on one of several ranks would leave the others waiting for ever: it ends them all, with the exit code of a run
  /// that failed.
  template <class F>
  auto together(F&& f) const {
    try {
      return f();
    } catch (const SolverError& error) {
      if (count_ > 1) give_up(error.what());
      throw;
    } catch (const std::bad_alloc&) {
      if (count_ > 1) give_up("out of memory");
      throw;
    }
  }

 private:
  Ranks() = default;
  [[noreturn]] void give_up(const char* text) const {
    std::fflush(stdout);
    std::fputs(fmt::format("error: rank {} of {}: {}\n", rank_, count_, text).c_str(), stderr);
    MPI_Abort(MPI_COMM_WORLD, 3);
    std::abort();
  }

  int count_ = 1;
  int rank_ = 0;
};

/// What a rank that works for the first one does.
void work_for_first_rank() {
  const Ranks& ranks = Ranks::get();
  std::optional<PetscSystem> system;
  SystemRows rows;
  std::vector<PetscScalar> right, result;
  for (;;) {
    const auto [task, detail] = ranks.wait();
    if (task == Task::end) return;
    ranks.together([&, task = task, detail = detail] {
      if (task == Task::make) {
        std::string options;
        std::vector<Real> tolerance;
        receive(0, options);
        receive(0, tolerance);
        try {
          system.emplace(ranks.comm(), static_cast<PetscMethod>(detail), tolerance.front(), options);
        } catch (const InputError&) {  // the first rank says it
        }
      } else if (task == Task::analyze) {
        std::vector<PetscInt> sizes;
        receive(0, sizes);
        rows.all = sizes[0];
        rows.block = sizes[1];
        receive(0, rows.begin);
        receive(0, rows.columns);
        receive(0, rows.positions);
      } else if (task == Task::factorize) {
        receive(0, rows.values);
        receive(0, rows.scales);
        system->set_up(rows, detail != 0);
      } else if (task == Task::release) {
        system.reset();
      } else {
        receive(0, right);
        system->solve(right, result);
        send(0, result.data(), result.size());
      }
    });
  }
}

class PetscSolver final : public LinearSolver {
 public:
  PetscSolver(std::string name, Real tolerance, const std::string& options);
  ~PetscSolver() override { ranks_.tell(Task::release); }
  std::string name() const override { return name_; }
  int iterations() const override { return system_->iterations(); }
  bool needs_places() const override { return name_ == "gamg"; }
  void place(UnknownPlaces places) override { places_ = std::move(places); }
  void analyze(const SparseMatrix& K) override;
  bool factorize(const SparseMatrix& K, Symmetry symmetry) override;
  bool solve(const Vector& b, Vector& x) override;

 private:
  /// The first row of a rank; whole nodes stay together.
  std::size_t first_row(int rank) const {
    const auto nodes = static_cast<std::size_t>(whole_.all / whole_.block);
    return nodes * static_cast<std::size_t>(rank) / static_cast<std::size_t>(ranks_.count()) * static_cast<std::size_t>(whole_.block);
  }
  /// Calls f(rank, its first row, the next rank's) for all but the first rank.
  template <class F>
  void for_each_other(F&& f) const {
    for (int rank = 1; rank < ranks_.count(); ++rank) f(rank, first_row(rank), first_row(rank + 1));
  }
  const SystemRows& own() const { return ranks_.count() > 1 ? own_ : whole_; }
  void set_values(const SparseMatrix& K, Symmetry symmetry);

  const Ranks& ranks_ = Ranks::get();
  std::string name_;
  std::optional<PetscSystem> system_;
  const SparseMatrix* K_ = nullptr;
  bool has_checked_options_ = false;
  UnknownPlaces places_;
  std::vector<int> rows_;  ///< By unknown: its row there, where prescribed components have one, too, so that each node has as many.
  SystemRows whole_;
  SystemRows own_;  ///< Of several ranks: the first one's.
  std::vector<PetscScalar> right_, own_right_, result_;
};

PetscSolver::PetscSolver(std::string name, Real tolerance, const std::string& options) : name_(std::move(name)) {
  start_petsc();
  const PetscMethod method = name_ == "gamg" ? PetscMethod::gamg : PetscMethod::mumps;
  ranks_.tell(Task::make, static_cast<int>(method));
  for (int rank = 1; rank < ranks_.count(); ++rank) {
    send(rank, options.data(), options.size());
    send(rank, &tolerance, 1);
  }
  ranks_.together([&] { system_.emplace(ranks_.comm(), method, tolerance, options); });
}

void PetscSolver::analyze(const SparseMatrix& K) {
  const auto unknowns = static_cast<std::size_t>(K.rows());
  rows_.resize(unknowns);
  std::size_t size = unknowns;
  if (places_.dim > 0) {
    size = places_.unknowns.size();
    for (std::size_t row = 0; row < size; ++row) {
      if (places_.unknowns[row] >= 0) rows_[static_cast<std::size_t>(places_.unknowns[row])] = static_cast<int>(row);
    }
  } else {
    for (std::size_t k = 0; k < unknowns; ++k) rows_[k] = static_cast<int>(k);
  }
  whole_.all = static_cast<PetscInt>(size);
  whole_.block = std::max(1, places_.dim);
  whole_.positions = places_.positions;
  // Rows have their entries where columns do: each pair of nodes has both blocks. Those of prescribed components have their diagonal.
  whole_.begin.assign(size + 1, 1);
  whole_.begin[0] = 0;
  for (std::size_t k = 0; k < unknowns; ++k)
    whole_.begin[static_cast<std::size_t>(rows_[k]) + 1] = K.outerIndexPtr()[k + 1] - K.outerIndexPtr()[k];
  for (std::size_t row = 0; row < size; ++row) whole_.begin[row + 1] += whole_.begin[row];
  whole_.columns.resize(static_cast<std::size_t>(whole_.begin.back()));
  whole_.values.resize(whole_.columns.size());
  for (std::size_t row = 0; row < size; ++row) whole_.columns[static_cast<std::size_t>(whole_.begin[row])] = static_cast<PetscInt>(row);
  for (std::size_t k = 0; k < unknowns; ++k) {
    auto at = static_cast<std::size_t>(whole_.begin[static_cast<std::size_t>(rows_[k])]);
    for (int e = K.outerIndexPtr()[k]; e < K.outerIndexPtr()[k + 1]; ++e)
      whole_.columns[at++] = rows_[static_cast<std::size_t>(K.innerIndexPtr()[e])];
  }
  right_.assign(size, 0);
  result_.assign(size, 0);
  if (ranks_.count() == 1) return;
  const auto rows_of = [&](std::size_t first, std::size_t last) {
    SystemRows rows;
    rows.all = whole_.all;
    rows.block = whole_.block;
    rows.begin.assign(whole_.begin.begin() + static_cast<std::ptrdiff_t>(first),
                      whole_.begin.begin() + static_cast<std::ptrdiff_t>(last) + 1);
    for (PetscInt& begin : rows.begin) begin -= whole_.begin[first];
    rows.columns.assign(whole_.columns.begin() + whole_.begin[first], whole_.columns.begin() + whole_.begin[last]);
    if (!whole_.positions.empty())
      rows.positions.assign(whole_.positions.begin() + static_cast<std::ptrdiff_t>(first),
                            whole_.positions.begin() + static_cast<std::ptrdiff_t>(last));
    return rows;
  };
  ranks_.tell(Task::analyze);
  for_each_other([&](int rank, std::size_t first, std::size_t last) {
    const SystemRows rows = rows_of(first, last);
    const PetscInt sizes[] = {rows.all, rows.block};
    send(rank, sizes, 2);
    send(rank, rows.begin.data(), rows.begin.size());
    send(rank, rows.columns.data(), rows.columns.size());
    send(rank, rows.positions.data(), rows.positions.size());
  });
  own_ = rows_of(0, first_row(1));
}

/// Each unknown is scaled so that its diagonal entry is 1: functions in thin cuts, which hold as little as 1e-10 of what others do, are
/// then nothing special to a smoother (as in de Prenter, Verhoosel, van Zwieten & van Brummelen 2017).
void PetscSolver::set_values(const SparseMatrix& K, Symmetry symmetry) {
  const Vector diagonal = K.diagonal();
  std::vector<Real>& scales = whole_.scales;
  scales.assign(static_cast<std::size_t>(whole_.all), 1);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const Real entry = std::abs(diagonal[static_cast<Eigen::Index>(k)]);
    if (entry > 0) scales[static_cast<std::size_t>(rows_[k])] = 1 / std::sqrt(entry);
  }
  std::fill(whole_.values.begin(), whole_.values.end(), 1);  // of prescribed components
  const auto take = [&](const auto& by_rows) {
    for (std::size_t k = 0; k < rows_.size(); ++k) {
      const auto row = static_cast<std::size_t>(rows_[k]);
      auto at = static_cast<std::size_t>(whole_.begin[row]);
      for (int e = by_rows.outerIndexPtr()[k]; e < by_rows.outerIndexPtr()[k + 1]; ++e, ++at)
        whole_.values[at] = by_rows.valuePtr()[e] * scales[row] * scales[static_cast<std::size_t>(whole_.columns[at])];
    }
  };
  if (symmetry == Symmetry::symmetric)
    take(K);
  else
    take(Eigen::SparseMatrix<Real, Eigen::RowMajor>(K));
}

bool PetscSolver::factorize(const SparseMatrix& K, Symmetry symmetry) {
  const bool is_symmetric = symmetry == Symmetry::symmetric;
  K_ = &K;
  set_values(K, symmetry);
  ranks_.tell(Task::factorize, is_symmetric ? 1 : 0);
  const auto place = [&](std::size_t row) { return static_cast<std::size_t>(whole_.begin[row]); };
  for_each_other([&](int rank, std::size_t first, std::size_t last) {
    send(rank, whole_.values.data() + place(first), place(last) - place(first));
    send(rank, whole_.scales.data() + first, last - first);
  });
  if (ranks_.count() > 1) {
    own_.values.assign(whole_.values.begin(), whole_.values.begin() + own_.begin.back());
    own_.scales.assign(whole_.scales.begin(), whole_.scales.begin() + own_.count());
  }
  return ranks_.together([&] { return system_->set_up(own(), is_symmetric); });
}

bool PetscSolver::solve(const Vector& b, Vector& x) {
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const auto row = static_cast<std::size_t>(rows_[k]);
    right_[row] = b[static_cast<Eigen::Index>(k)] * whole_.scales[row];
  }
  ranks_.tell(Task::solve);
  for_each_other([&](int rank, std::size_t first, std::size_t last) { send(rank, right_.data() + first, last - first); });
  own_right_.assign(right_.begin(), right_.begin() + own().count());
  const bool has_converged = ranks_.together([&] { return system_->solve(own_right_, result_); });
  for_each_other([&](int rank, std::size_t, std::size_t) {
    std::vector<PetscScalar> others;
    receive(rank, others);
    result_.insert(result_.end(), others.begin(), others.end());
  });
  if (!has_checked_options_) system_->refuse_unused_options();
  has_checked_options_ = true;
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const auto row = static_cast<std::size_t>(rows_[k]);
    x[static_cast<Eigen::Index>(k)] = result_[row] * whole_.scales[row];
  }
  return has_converged && is_solved(*K_, b, x);
}

/// What the starters of ranks say of their number.
bool is_one_of_many() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"}) {
    const char* const value = std::getenv(name);
    if (value != nullptr && std::atoi(value) > 1) return true;
  }
  return false;
}

}  // namespace

std::unique_ptr<LinearSolver> make_petsc_solver(const std::string& name, Real tolerance, const std::string& options) {
  return std::make_unique<PetscSolver>(name, tolerance, options);
}

int petsc_rank_count() { return Ranks::get().count(); }

bool join_petsc_ranks() {
  if (!is_one_of_many()) return false;
  start_petsc();
  Ranks::get().join();
  if (Ranks::get().rank() == 0) return false;
  // What the starter passes on to all ranks is for the first one to answer: it ends the run in order, and this rank with it.
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2}) std::signal(number, SIG_IGN);
  work_for_first_rank();
  return true;
}

}  // namespace matpoint
