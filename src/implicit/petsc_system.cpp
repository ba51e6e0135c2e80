#include "implicit/petsc_system.hpp"

#include <algorithm>
#include <cctype>
#include <mutex>
#include <sstream>

#include <petscblaslapack.h>

#include "core/error.hpp"

namespace matpoint {
namespace {

/// What PETSc's error handler has heard first: what went wrong, before the functions above it failed as well.
struct Complaint {
  PetscErrorCode code = 0;
  std::string text;
};
Complaint& first_complaint() {
  static Complaint one;
  return one;
}

PetscErrorCode note_complaint(MPI_Comm, int, const char*, const char*, PetscErrorCode code, PetscErrorType type, const char* message,
                              void*) {
  if (type == PETSC_ERROR_INITIAL) first_complaint() = {code, message == nullptr ? "" : message};
  return code;
}

/// OpenBLAS takes its memory when it first needs it, and tries for ever where there is none: it shall have it before the matrices.
void wake_blas() {
  constexpr PetscBLASInt n = 256;
  constexpr PetscBLASInt step = 1;
  constexpr PetscScalar one = 1;
  const std::vector<PetscScalar> matrix(static_cast<std::size_t>(n * n), 1);
  const std::vector<PetscScalar> right(static_cast<std::size_t>(n), 1);
  std::vector<PetscScalar> result(static_cast<std::size_t>(n), 0);
  BLASgemv_("N", &n, &n, &one, matrix.data(), &n, right.data(), &step, &one, result.data(), &step);
}

class Library {
 public:
  Library() {
    // Signals are the program's own: they end a run with all that it has computed.
    PetscOptionsSetValue(nullptr, "-no_signal_handler", "true");
    PETSC_MPI_THREAD_REQUIRED = MPI_THREAD_SERIALIZED;
    if (PetscInitializeNoArguments() != 0) throw SolverError("PETSc, or MPI under it, could not be started");
    PetscPushErrorHandler(note_complaint, nullptr);
    wake_blas();
  }
  ~Library() {
    int is_over = 0;  // whoever has started MPI, as mpi4py, may have ended it
    MPI_Finalized(&is_over);
    if (is_over == 0) PetscFinalize();
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
};

/// PETSc is for one thread at a time, and simulations may run side by side.
std::recursive_mutex& petsc_mutex() {
  static std::recursive_mutex one;
  return one;
}

/// While it lives, PETSc is this thread's, and reads its options from these.
class OptionsInUse {
 public:
  explicit OptionsInUse(PetscOptions options) : lock_(petsc_mutex()) { require_petsc(PetscOptionsPush(options)); }
  ~OptionsInUse() { PetscOptionsPop(); }
  OptionsInUse(const OptionsInUse&) = delete;
  OptionsInUse& operator=(const OptionsInUse&) = delete;

 private:
  std::lock_guard<std::recursive_mutex> lock_;
};

/// Smoothed aggregation from the rigid motions. Its smoother makes the difference on the nearly empty cells at a body's surface
/// (docs/large_problems.md has the counts): incomplete Cholesky needs the fewest iterations by far where it exists without a shift, and
/// relaxation needs the same everywhere. The last one is for relaxation's own weakness, coarse nodes without a stiffness.
constexpr const char* k_gamg =
    "-pc_type gamg -pc_gamg_type agg -pc_gamg_agg_nsmooths 1 -mg_levels_ksp_type chebyshev -mg_levels_ksp_max_it 2 -ksp_gmres_restart 60 "
    "-mg_levels_sub_pc_type icc -mg_levels_sub_pc_factor_shift_type positive_definite -mg_levels_sub_pc_factor_mat_ordering_type rcm";
const char* const k_incomplete = "-mg_levels_pc_type bjacobi";
const char* const k_relaxation = "-mg_levels_pc_type sor";
constexpr const char* k_mumps = "-pc_factor_mat_solver_type mumps";

std::vector<std::string> option_names(const std::string& options) {
  std::vector<std::string> names;
  std::istringstream words(options);
  for (std::string word; words >> word;) {
    if (word.size() > 1 && word[0] == '-' && std::isalpha(static_cast<unsigned char>(word[1])) != 0) names.push_back(word.substr(1));
  }
  return names;
}

}  // namespace

void start_petsc() {
  const std::lock_guard lock(petsc_mutex());
  static const Library one;
}

void require_petsc(PetscErrorCode code) {
  if (code == 0) return;
  const Complaint& first = first_complaint();
  const char* general = nullptr;
  PetscErrorMessage(first.code != 0 ? first.code : code, &general, nullptr);
  // Where it finds no memory, PETSc 3.18 gives a line of its own text in the place of an error's number.
  if (general == nullptr || first.code == PETSC_ERR_MEM) throw SolverError("PETSc is probably out of memory: it stopped in {}", first.text);
  throw SolverError("PETSc: {}{}{}", general, first.text.empty() ? "" : ": ", first.text);
}

PetscSystem::PetscSystem(MPI_Comm comm, PetscMethod method, Real tolerance, const std::string& options)
    : comm_(comm), method_(method), tolerance_(tolerance), asked_(option_names(options)) {
  const std::lock_guard lock(petsc_mutex());
  require_petsc(PetscOptionsCreate(options_.renew()));
  require_petsc(PetscOptionsInsertString(options_.get(), method == PetscMethod::gamg ? k_gamg : k_mumps));
  if (PetscOptionsInsertString(options_.get(), options.c_str()) != 0)
    throw InputError("solver.petsc: \"{}\" are no options of PETSc: {}", options, first_complaint().text);
  const auto is_asked = [&](const char* name) { return std::find(asked_.begin(), asked_.end(), name) != asked_.end(); };
  if (method == PetscMethod::mumps || is_asked("pc_type") || is_asked("mg_levels_pc_type"))
    smoothers_ = {{"", 10'000}};
  else
    smoothers_ = {{k_incomplete, 50}, {k_relaxation, 500}, {k_incomplete, 2000}};
}

PetscSystem::~PetscSystem() {
  const std::lock_guard lock(petsc_mutex());
  krylov_.renew();
  matrix_.renew();
  options_.renew();
}

bool PetscSystem::set_up(const SystemRows& rows, bool is_symmetric) {
  const OptionsInUse in_use(options_.get());
  is_symmetric_ = is_symmetric;
  block_ = rows.block;
  all_ = rows.all;
  // Anew for each matrix, as everything on it: what PETSc keeps from the last one would be lost in a checkpoint, and change bits.
  krylov_.renew();
  int ranks = 1;
  MPI_Comm_size(comm_, &ranks);
  if (ranks == 1)
    require_petsc(MatCreateSeqAIJWithArrays(comm_, rows.all, rows.all, const_cast<PetscInt*>(rows.begin.data()),
                                            const_cast<PetscInt*>(rows.columns.data()), const_cast<PetscScalar*>(rows.values.data()),
                                            matrix_.renew()));
  else
    require_petsc(MatCreateMPIAIJWithArrays(comm_, rows.count(), rows.count(), rows.all, rows.all, rows.begin.data(), rows.columns.data(),
                                            rows.values.data(), matrix_.renew()));
  require_petsc(MatSetBlockSize(matrix_.get(), rows.block));
  if (is_symmetric) require_petsc(MatSetOption(matrix_.get(), MAT_SYMMETRIC, PETSC_TRUE));
  if (method_ == PetscMethod::gamg && !rows.positions.empty()) set_rigid_motions(rows);
  return set_up_krylov(method_ == PetscMethod::mumps ? KSPPREONLY : is_symmetric ? KSPCG : KSPFGMRES, smoothers_.front());
}

/// What multigrid must keep on its coarse grids: the motions without forces, in the scaled unknowns.
void PetscSystem::set_rigid_motions(const SystemRows& rows) {
  Owned<::Vec, VecDestroy> positions, scales;
  require_petsc(VecCreateMPIWithArray(comm_, rows.block, rows.count(), rows.all, rows.positions.data(), positions.renew()));
  require_petsc(VecCreateMPIWithArray(comm_, rows.block, rows.count(), rows.all, rows.scales.data(), scales.renew()));
  Owned<MatNullSpace, MatNullSpaceDestroy> motions;
  require_petsc(MatNullSpaceCreateRigidBody(positions.get(), motions.renew()));
  PetscInt count = 0;
  const ::Vec* of_unscaled = nullptr;
  require_petsc(MatNullSpaceGetVecs(motions.get(), nullptr, &count, &of_unscaled));
  std::vector<Owned<::Vec, VecDestroy>> scaled(static_cast<std::size_t>(count));
  std::vector<::Vec> handles;
  for (std::size_t k = 0; k < scaled.size(); ++k) {
    require_petsc(VecDuplicate(of_unscaled[k], scaled[k].renew()));
    require_petsc(VecPointwiseDivide(scaled[k].get(), of_unscaled[k], scales.get()));
    for (const ::Vec other : handles) {
      PetscScalar along = 0;
      require_petsc(VecDot(scaled[k].get(), other, &along));
      require_petsc(VecAXPY(scaled[k].get(), -along, other));
    }
    require_petsc(VecNormalize(scaled[k].get(), nullptr));
    handles.push_back(scaled[k].get());
  }
  require_petsc(MatNullSpaceCreate(comm_, PETSC_FALSE, count, handles.data(), motions.renew()));
  require_petsc(MatSetNearNullSpace(matrix_.get(), motions.get()));
}

bool PetscSystem::set_up_krylov(KSPType type, const Smoother& smoother) {
  if (!smoother.options.empty()) require_petsc(PetscOptionsInsertString(options_.get(), smoother.options.c_str()));
  require_petsc(KSPCreate(comm_, krylov_.renew()));
  require_petsc(KSPSetType(krylov_.get(), type));
  require_petsc(KSPSetOperators(krylov_.get(), matrix_.get(), matrix_.get()));
  require_petsc(KSPSetTolerances(krylov_.get(), tolerance_, PETSC_DEFAULT, PETSC_DEFAULT, smoother.iterations_max));
  PC preconditioner = nullptr;
  require_petsc(KSPGetPC(krylov_.get(), &preconditioner));
  if (method_ == PetscMethod::gamg)
    require_petsc(KSPSetNormType(krylov_.get(), KSP_NORM_UNPRECONDITIONED));
  else
    require_petsc(PCSetType(preconditioner, is_symmetric_ ? PCCHOLESKY : PCLU));
  require_petsc(KSPSetFromOptions(krylov_.get()));
  require_petsc(KSPSetUp(krylov_.get()));
  PCFailedReason reason = PC_NOERROR;
  require_petsc(PCGetFailedReason(preconditioner, &reason));
  return reason == PC_NOERROR;
}

KSPConvergedReason PetscSystem::solve_krylov(::Vec b, ::Vec x) {
  require_petsc(KSPSolve(krylov_.get(), b, x));
  PetscInt taken = 0;
  require_petsc(KSPGetIterationNumber(krylov_.get(), &taken));
  if (method_ == PetscMethod::gamg) iterations_ += static_cast<int>(taken);
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  require_petsc(KSPGetConvergedReason(krylov_.get(), &reason));
  return reason;
}

bool PetscSystem::solve(const std::vector<PetscScalar>& right, std::vector<PetscScalar>& result) {
  const OptionsInUse in_use(options_.get());
  const auto count = static_cast<PetscInt>(right.size());
  result.assign(right.size(), 0);
  Owned<::Vec, VecDestroy> b, x;
  require_petsc(VecCreateMPIWithArray(comm_, block_, count, all_, right.data(), b.renew()));
  require_petsc(VecCreateMPIWithArray(comm_, block_, count, all_, result.data(), x.renew()));
  iterations_ = 0;
  KSPConvergedReason reason = solve_krylov(b.get(), x.get());
  // From the first one again for each matrix: a run that goes on from a checkpoint knows nothing of how the last ones went.
  bool is_definite = is_symmetric_;
  for (std::size_t s = 0; reason <= 0 && method_ == PetscMethod::gamg;) {
    // Conjugate gradients break down on a matrix that is not definite.
    const bool is_indefinite = is_definite && (reason == KSP_DIVERGED_INDEFINITE_MAT || reason == KSP_DIVERGED_INDEFINITE_PC);
    if (is_indefinite)
      is_definite = false;
    else if (++s == smoothers_.size())
      break;
    if (!set_up_krylov(is_definite ? KSPCG : KSPFGMRES, smoothers_[s])) continue;
    require_petsc(VecSet(x.get(), 0));
    reason = solve_krylov(b.get(), x.get());
  }
  return reason > 0;
}

void PetscSystem::refuse_unused_options() const {
  const std::lock_guard lock(petsc_mutex());
  PetscInt count = 0;
  char** names = nullptr;
  char** values = nullptr;
  require_petsc(PetscOptionsLeftGet(options_.get(), &count, &names, &values));
  std::string unused;
  for (PetscInt k = 0; k < count; ++k) {
    if (std::find(asked_.begin(), asked_.end(), names[k]) != asked_.end())
      unused += fmt::format("{}-{}", unused.empty() ? "" : ", ", names[k]);
  }
  require_petsc(PetscOptionsLeftRestore(options_.get(), &count, &names, &values));
  if (!unused.empty()) throw InputError("solver.petsc: nothing uses {} here; -help prints what PETSc would, -ksp_view what it has", unused);
}

}  // namespace matpoint
