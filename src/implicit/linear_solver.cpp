#include "implicit/linear_solver.hpp"

#include <dlfcn.h>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>
#include <unsupported/Eigen/IterativeSolvers>
#ifdef MATPOINT_HAS_SUITESPARSE
#include <Eigen/CholmodSupport>
#include <Eigen/UmfPackSupport>
#endif

#include "core/error.hpp"
#ifdef MATPOINT_HAS_PETSC
#include "implicit/petsc_solver.hpp"
#endif

namespace matpoint {
namespace {

/// The same bits for any number of threads: a threaded BLAS adds in another order.
void use_one_blas_thread() {
  if (void* const set = dlsym(RTLD_DEFAULT, "openblas_set_num_threads")) reinterpret_cast<void (*)(int)>(set)(1);
}

#ifdef MATPOINT_HAS_SUITESPARSE
// Eigen's faces keep to themselves what SuiteSparse tells of its pivots.
struct Cholmod : Eigen::CholmodSupernodalLLT<SparseMatrix> {
  Real pivot_ratio() { return cholmod_rcond(m_cholmodFactor, &cholmod()); }
};
struct Umfpack : Eigen::UmfPackLU<SparseMatrix> {
  Real pivot_ratio() { return m_umfpackInfo(UMFPACK_RCOND); }
};
#endif

/// A direct method of Eigen or behind Eigen's face.
template <class Method>
class Direct final : public LinearSolver {
 public:
  explicit Direct(std::string name) : name_(std::move(name)) {
    // CHOLMOD would print that a matrix is not positive definite; whoever asked hears it from factorize.
    if constexpr (requires { method_.cholmod(); }) method_.cholmod().print = 0;
  }
  std::string name() const override { return name_; }
  void analyze(const SparseMatrix& K) override { method_.analyzePattern(K); }
  bool factorize(const SparseMatrix& K, Symmetry) override {
    K_ = &K;
    method_.factorize(K);
    return method_.info() == Eigen::Success;
  }
  bool solve(const Vector& b, Vector& x) override {
    x = method_.solve(b);
    return is_solved(*K_, b, x);
  }
  Real pivot_ratio() override {
    if constexpr (requires { method_.pivot_ratio(); }) return method_.pivot_ratio();
    return 0;
  }

 private:
  std::string name_;
  Method method_;
  const SparseMatrix* K_ = nullptr;
};

template <class Method>
class Iterative final : public LinearSolver {
 public:
  Iterative(std::string name, Real tolerance) : name_(std::move(name)) {
    method_.setTolerance(tolerance);
    method_.setMaxIterations(5000);
    if constexpr (requires { method_.preconditioner().setDroptol(1e-4); }) {
      method_.preconditioner().setDroptol(1e-4);
      method_.preconditioner().setFillfactor(10);
    }
    if constexpr (requires { method_.set_restart(60); }) method_.set_restart(60);
  }
  std::string name() const override { return name_; }
  // At once in factorize: Eigen's own analysis asks the preconditioner for the state of a factorisation that has not been made.
  void analyze(const SparseMatrix&) override {}
  bool factorize(const SparseMatrix& K, Symmetry) override {
    method_.compute(K);
    return method_.info() == Eigen::Success;
  }
  bool solve(const Vector& b, Vector& x) override {
    x = method_.solve(b);
    return method_.info() == Eigen::Success && x.allFinite();
  }
  int iterations() const override { return static_cast<int>(method_.iterations()); }

 private:
  std::string name_;
  Method method_;
};

using Ldlt = Eigen::SimplicialLDLT<SparseMatrix>;
#ifdef MATPOINT_HAS_SUITESPARSE
using Supernodal = Direct<Cholmod>;
#endif
using SparseLu = Eigen::SparseLU<SparseMatrix, Eigen::COLAMDOrdering<int>>;
using Ilut = Eigen::IncompleteLUT<Real>;

/// A Cholesky factorisation that refuses what is not positive definite, where it would lose its accuracy.
class DefiniteLdlt final : public LinearSolver {
 public:
  std::string name() const override { return "ldlt"; }
  void analyze(const SparseMatrix& K) override { method_.analyzePattern(K); }
  bool factorize(const SparseMatrix& K, Symmetry) override {
    K_ = &K;
    method_.factorize(K);
    return method_.info() == Eigen::Success && method_.vectorD().minCoeff() > 0;
  }
  bool solve(const Vector& b, Vector& x) override {
    x = method_.solve(b);
    return is_solved(*K_, b, x);
  }
  Real pivot_ratio() override { return method_.vectorD().minCoeff() / method_.vectorD().maxCoeff(); }

 private:
  Ldlt method_;
  const SparseMatrix* K_ = nullptr;
};

std::unique_ptr<LinearSolver> make_lu() {
#ifdef MATPOINT_HAS_SUITESPARSE
  return std::make_unique<Direct<Umfpack>>("umfpack");
#else
  return std::make_unique<Direct<SparseLu>>("sparse_lu");
#endif
}

/// The Cholesky factorisation for a matrix of so many rows: supernodes pay once they are filled (docs/implicit.md has the measurements).
std::unique_ptr<LinearSolver> make_cholesky(bool is_large) {
#ifdef MATPOINT_HAS_SUITESPARSE
  if (is_large) return std::make_unique<Supernodal>("cholmod");
#else
  static_cast<void>(is_large);
#endif
  return std::make_unique<DefiniteLdlt>();
}

/// Multigrid for a system of so many rows, where it is faster than a factorisation or the ranks are there to share it
/// (docs/large_problems.md has the measurements); null elsewhere, and in a build without PETSc.
std::unique_ptr<LinearSolver> make_multigrid([[maybe_unused]] int dim, [[maybe_unused]] Eigen::Index rows,
                                             [[maybe_unused]] Real tolerance) {
#ifdef MATPOINT_HAS_PETSC
  constexpr Eigen::Index k_large = 20'000;
  // What has not converged by then is not for it.
  if (petsc_rank_count() > 1 || (dim == 3 && rows >= k_large)) return make_petsc_solver("gamg", tolerance, "-ksp_max_it 300");
#endif
  return nullptr;
}

class Automatic final : public LinearSolver {
 public:
  explicit Automatic(Real tolerance) : tolerance_(tolerance) {}
  std::string name() const override { return used_ == nullptr ? "auto" : used_->name(); }
  bool needs_places() const override { return true; }
  void place(UnknownPlaces places) override { places_ = std::move(places); }
  void analyze(const SparseMatrix& K) override {
    is_cholesky_ready_ = is_lu_ready_ = false;
    used_ = nullptr;
    multigrid_.reset();  // one at a time: on ranks they share what works for them
    multigrid_ = make_multigrid(places_.dim, K.rows(), tolerance_);
    if (multigrid_ == nullptr) return;
    multigrid_->place(std::move(places_));
    multigrid_->analyze(K);
  }
  bool factorize(const SparseMatrix& K, Symmetry symmetry) override {
    K_ = &K;
    symmetry_ = symmetry;
    used_ = multigrid_.get();
    return (used_ != nullptr && used_->factorize(K, symmetry)) || factorize_directly();
  }
  bool solve(const Vector& b, Vector& x) override {
    if (used_->solve(b, x)) return true;
    return used_ == multigrid_.get() && factorize_directly() && used_->solve(b, x);
  }
  Real pivot_ratio() override { return used_ == nullptr ? 0 : used_->pivot_ratio(); }
  int iterations() const override { return used_ == nullptr ? 0 : used_->iterations(); }

 private:
  static constexpr Eigen::Index k_large = 1000;  ///< Unknowns.
  bool factorize_directly() {
    if (symmetry_ == Symmetry::symmetric) {
      if (!is_cholesky_ready_) {
        cholesky_ = make_cholesky(K_->rows() >= k_large);
        cholesky_->analyze(*K_);
      }
      used_ = cholesky_.get();
      is_cholesky_ready_ = true;
      if (cholesky_->factorize(*K_, symmetry_)) return true;
    }
    used_ = lu_.get();
    if (!is_lu_ready_) lu_->analyze(*K_);
    is_lu_ready_ = true;
    return lu_->factorize(*K_, symmetry_);
  }

  Real tolerance_;
  UnknownPlaces places_;
  std::unique_ptr<LinearSolver> multigrid_;  ///< Null where it is not worth its while.
  std::unique_ptr<LinearSolver> cholesky_;
  std::unique_ptr<LinearSolver> lu_ = make_lu();
  LinearSolver* used_ = nullptr;
  const SparseMatrix* K_ = nullptr;
  Symmetry symmetry_ = Symmetry::general;
  bool is_cholesky_ready_ = false;
  bool is_lu_ready_ = false;
};

}  // namespace

bool is_solved(const SparseMatrix& K, const Vector& b, const Vector& x) {
  constexpr Real k_residual_max = 1e-6;
  return x.allFinite() && (K * x - b).norm() <= k_residual_max * b.norm();
}

std::unique_ptr<LinearSolver> make_linear_solver(const std::string& name, Real tolerance,
                                                 [[maybe_unused]] const std::string& petsc_options) {
  use_one_blas_thread();
#ifdef MATPOINT_HAS_PETSC
  if (name == "gamg" || name == "mumps") return make_petsc_solver(name, tolerance, petsc_options);
#endif
#ifdef MATPOINT_HAS_SUITESPARSE
  if (name == "umfpack") return make_lu();
  if (name == "cholmod") return std::make_unique<Supernodal>(name);
#endif
  if (name == "ldlt") return std::make_unique<DefiniteLdlt>();
  if (name == "sparse_lu") return std::make_unique<Direct<SparseLu>>(name);
  if (name == "cg") {
    using Preconditioner = Eigen::IncompleteCholesky<Real>;
    return std::make_unique<Iterative<Eigen::ConjugateGradient<SparseMatrix, Eigen::Lower, Preconditioner>>>(name, tolerance);
  }
  if (name == "bicgstab") return std::make_unique<Iterative<Eigen::BiCGSTAB<SparseMatrix, Ilut>>>(name, tolerance);
  if (name == "gmres") return std::make_unique<Iterative<Eigen::GMRES<SparseMatrix, Ilut>>>(name, tolerance);
  if (name != "auto") throw InputError("linear solver \"{}\" is unknown, allowed: {}", name, list_names(linear_solver_names()));
  return std::make_unique<Automatic>(tolerance);
}

int linear_solver_ranks() {
#ifdef MATPOINT_HAS_PETSC
  return petsc_rank_count();
#else
  return 1;
#endif
}

bool works_for_first_rank() {
#ifdef MATPOINT_HAS_PETSC
  return join_petsc_ranks();
#else
  return false;
#endif
}

}  // namespace matpoint
