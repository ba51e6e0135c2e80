#include "implicit/petsc_system.hpp"

#include <algorithm>
#include <cctype>
#include <sstream>

#include "core/error.hpp"

namespace matpoint {
namespace {

/// What PETSc's error handler has heard first: what went wrong, before the functions above it failed as well.
std::string& first_complaint() {
  static std::string text;
  return text;
}

PetscErrorCode note_complaint(MPI_Comm, int, const char*, const char*, PetscErrorCode code, PetscErrorType type, const char* message,
                              void*) {
  if (type == PETSC_ERROR_INITIAL) first_complaint() = message == nullptr ? "" : message;
  return code;
}

class Library {
 public:
  Library() {
    // Signals are the program's own: they end a run with all that it has computed.
    PetscOptionsSetValue(nullptr, "-no_signal_handler", "true");
    if (PetscInitializeNoArguments() != 0) throw SolverError("PETSc, or MPI under it, could not be started");
    PetscPushErrorHandler(note_complaint, nullptr);
  }
  ~Library() {
    int is_over = 0;  // whoever has started MPI, as mpi4py, may have ended it
    MPI_Finalized(&is_over);
    if (is_over == 0) PetscFinalize();
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
};

/// While it lives, PETSc reads its options from these.
class OptionsInUse {
 public:
  explicit OptionsInUse(PetscOptions options) { require_petsc(PetscOptionsPush(options)); }
  ~OptionsInUse() { PetscOptionsPop(); }
  OptionsInUse(const OptionsInUse&) = delete;
  OptionsInUse& operator=(const OptionsInUse&) = delete;
};

/// Smoothed aggregation from the rigid motions, with a smoother that stays positive on the nearly empty cells at a body's surface
/// (docs/large_problems.md says what others do there).
constexpr const char* k_gamg =
    "-pc_type gamg -pc_gamg_type agg -pc_gamg_agg_nsmooths 1 -mg_levels_ksp_type chebyshev -mg_levels_ksp_max_it 2 "
    "-mg_levels_pc_type bjacobi -mg_levels_sub_pc_type icc -mg_levels_sub_pc_factor_shift_type positive_definite "
    "-ksp_max_it 2000 -ksp_gmres_restart 60";
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

void start_petsc() { static const Library one; }

void require_petsc(PetscErrorCode code) {
  if (code == 0) return;
  const char* general = nullptr;
  PetscErrorMessage(code, &general, nullptr);
  throw SolverError("PETSc: {}{}{}", general == nullptr ? "unknown error" : general, first_complaint().empty() ? "" : ": ",
                    first_complaint());
}

PetscSystem::PetscSystem(MPI_Comm comm, PetscMethod method, Real tolerance, const std::string& options)
    : comm_(comm), method_(method), tolerance_(tolerance), asked_(option_names(options)) {
  require_petsc(PetscOptionsCreate(options_.renew()));
  require_petsc(PetscOptionsInsertString(options_.get(), method == PetscMethod::gamg ? k_gamg : k_mumps));
  if (PetscOptionsInsertString(options_.get(), options.c_str()) != 0)
    throw InputError("solver.petsc: \"{}\" are no options of PETSc: {}", options, first_complaint());
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
  if (method_ == PetscMethod::gamg && !rows.positions.empty()) {
    Owned<::Vec, VecDestroy> positions;
    require_petsc(VecCreateMPIWithArray(comm_, rows.block, static_cast<PetscInt>(rows.positions.size()), PETSC_DECIDE,
                                        rows.positions.data(), positions.renew()));
    Owned<MatNullSpace, MatNullSpaceDestroy> motions;
    require_petsc(MatNullSpaceCreateRigidBody(positions.get(), motions.renew()));
    require_petsc(MatSetNearNullSpace(matrix_.get(), motions.get()));
  }
  return set_up_krylov(method_ == PetscMethod::mumps ? KSPPREONLY : is_symmetric ? KSPCG : KSPFGMRES);
}

bool PetscSystem::set_up_krylov(KSPType type) {
  require_petsc(KSPCreate(comm_, krylov_.renew()));
  require_petsc(KSPSetType(krylov_.get(), type));
  require_petsc(KSPSetOperators(krylov_.get(), matrix_.get(), matrix_.get()));
  require_petsc(KSPSetTolerances(krylov_.get(), tolerance_, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
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

bool PetscSystem::solve(const std::vector<PetscScalar>& right, std::vector<PetscScalar>& result) {
  const OptionsInUse in_use(options_.get());
  const auto count = static_cast<PetscInt>(right.size());
  result.resize(right.size());
  Owned<::Vec, VecDestroy> b, x;
  require_petsc(VecCreateMPIWithArray(comm_, block_, count, all_, right.data(), b.renew()));
  require_petsc(VecCreateMPIWithArray(comm_, block_, count, all_, result.data(), x.renew()));
  iterations_ = 0;
  const auto try_solve = [&] {
    require_petsc(KSPSolve(krylov_.get(), b.get(), x.get()));
    PetscInt taken = 0;
    require_petsc(KSPGetIterationNumber(krylov_.get(), &taken));
    if (method_ == PetscMethod::gamg) iterations_ += static_cast<int>(taken);
    KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
    require_petsc(KSPGetConvergedReason(krylov_.get(), &reason));
    return reason;
  };
  KSPConvergedReason reason = try_solve();
  // Conjugate gradients break down on a matrix that is not definite.
  if (method_ == PetscMethod::gamg && (reason == KSP_DIVERGED_INDEFINITE_MAT || reason == KSP_DIVERGED_INDEFINITE_PC))
    reason = set_up_krylov(KSPFGMRES) ? try_solve() : reason;
  return reason > 0;
}

void PetscSystem::refuse_unused_options() const {
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
