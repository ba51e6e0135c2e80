// The residual of an implicit step and its exact derivative, summed over particles as quadrature points.
//
// Per particle, with A = I + sum_K u_K g*_K the deformation in the step, and S = tau A^-T from the law with its derivative dS/dA:
//   r_I  += V0 S g_I + m N_I (c_u du - c_v v - c_a a - b),   du = sum_K N_K u_K
//   K_IK += V0 g_I (dS/dA) g*_K + m c_u N_I N_K
// The residual at a prescribed component is the force that holds it. So friction at a node that slips on a face, which goes by that force
// across the face, is a row of the same node times a number, in the residual and in its derivative.
// Cells are worked in parallel into matrices of their own; these are added to the sparse matrix in the order of the cells, so that the
// result has the same bits for any number of threads.
#pragma once

#include "core/profile.hpp"
#include "implicit/body_contact.hpp"
#include "implicit/linear_solver.hpp"
#include "implicit/point_loads.hpp"
#include "implicit/side_contact.hpp"
#include "implicit/step_space.hpp"
#include "implicit/surface_faces.hpp"
#include "implicit/volume_patches.hpp"
#include "material/tangent.hpp"

namespace matpoint {

/// The acceleration at the end of a step, c_u du - c_v v - c_a a; all 0 without inertia.
struct StepInertia {
  Real u = 0;  ///< [1/s^2]
  Real v = 0;  ///< [1/s]
  Real a = 0;  ///< [1]
};

/// Friction on a node that slips on a face: the face's force along itself is -share times its force across. The share turns with the
/// node's displacement u, as share + slope u.
template <int Dim>
struct FaceFriction {
  int axis = -1;                        ///< Across the face; -1: no friction.
  Vec<Dim> share{};                     ///< [1]
  std::array<Real, Dim * Dim> slope{};  ///< [1/m]
  Vec<Dim> at(const Real* u) const {
    Vec<Dim> all = share;
    for (std::size_t d = 0; d < Dim; ++d) {
      for (std::size_t e = 0; e < Dim; ++e) all[d] += slope[d * Dim + e] * u[e];
    }
    return all;
  }
};

/// What a step adds to the particles' equations.
template <int Dim>
struct StepLoad {
  Real dt = 0;  ///< [s]
  StepInertia inertia;
  Vec<Dim> gravity{};  ///< At the end of the step [m/s^2].
  /// The same beside gravity, by source: Dim numbers per row; empty without.
  std::vector<std::vector<Real>> body_force;
  /// Of the case's loads on particles, at the end of the step [1].
  std::vector<Real> factors;
  /// Forces on nodes by active node and component [N]; empty without.
  std::vector<Real> nodal_force;
  /// By active node; empty without. Of such a node the residual along the face is what its friction leaves.
  std::vector<FaceFriction<Dim>> friction;
  Real b(std::size_t source, Real weight_ratio, std::size_t row, std::size_t d) const {
    const Real other = body_force.empty() || body_force[source].empty() ? 0 : body_force[source][row * Dim + d];
    return weight_ratio * gravity[d] + other;
  }
};

/// The first particle that a displacement would turn inside out.
struct Inversion {
  std::size_t source = 0;
  Index row = -1;  ///< Of the source; -1 if there is none.
  Real J = 1;      ///< det A
  bool is_found() const { return row >= 0; }
};

/// What prescribed displacements of nodes do to the equations of the others: K_fp u_p.
struct Lift {
  const std::vector<Real>* displacement = nullptr;  ///< u_p by active node and component, 0 at unknowns [m].
  Vector force;                                     ///< Out: by unknown [N].
};

template <int Dim>
class Assembly {
 public:
  /// With patches of so many cells in each direction for nearly incompressible bodies. Throws InputError for a law without a tangent.
  Assembly(const StepSpace<Dim>& space, BodyContact<Dim>& contact, const SideContact<Dim>& sides, PointLoads<Dim>& loads, int patch_width,
           bool has_linear_patches, Real surface_penalty);

  /// To be called when the space has been updated, and the contact with it: makes the sparse matrix's places if they changed, the soft
  /// stiffness, and the places of loads.
  void start();

  /// Residual by active node and component [N], Dim numbers per node, of the step displacements `u` [m].
  void residual(const std::vector<Real>& u, const StepLoad<Dim>& load, std::vector<Real>& out) { assemble(u, load, out, nullptr); }
  /// The same and matrix(), and what `lift` asks for.
  void residual_and_matrix(const std::vector<Real>& u, const StepLoad<Dim>& load, std::vector<Real>& out, Lift& lift) {
    assemble(u, load, out, &lift);
  }
  const SparseMatrix& matrix() const { return matrix_; }
  /// Whether contact, which begins and ends abruptly, may have a part in this step.
  bool may_touch() const { return contact_.is_near() || sides_.is_near(); }
  /// Changes when the matrix's places do: in start(), and where particles of bodies in contact go far in a step.
  Index pattern() const { return pattern_; }

  /// What cannot be taken of the displacements: a particle is turned inside out, or bodies run too deep into each other. Empty if nothing.
  std::string find_fault(const std::vector<Real>& u);

  /// A of all particles as their laws see it, Dim x Dim numbers each, and their displacements [m], in the order of the space's particles.
  void deform(const std::vector<Real>& u, std::vector<Real>& A, std::vector<Vec<Dim>>& du) const;

  /// Forces of the soft stiffness by active node and component [N].
  void soft_force(const std::vector<Real>& u, std::vector<Real>& out) const;

  /// Work of the stresses in the displacements of the step, by their parts.
  struct StressWork {
    Real start = 0;             ///< Of the stresses at its start, with the true gradients: sum of V0 tau : (A - I) [J].
    Real correction_start = 0;  ///< What the corrected gradients of receding particles add to it [J],
    Real correction_end = 0;    ///< and to the work of the stresses at its end [J].
  };
  StressWork stress_work(const std::vector<Real>& u, Real dt) const;

  TangentFunction<Dim> law(std::size_t source) const { return laws_[source].evaluate; }

 private:
  struct Kernels;
  /// The least det A under the displacements; not positive or not finite is an inversion.
  Inversion find_inversion(const std::vector<Real>& u) const;
  std::string describe(const Inversion& inversion) const;
  void assemble(const std::vector<Real>& u, const StepLoad<Dim>& load, std::vector<Real>& residual, Lift* lift);
  void make_pattern();
  void make_soft_stiffness();
  void assemble_sides(const std::vector<Real>& u, const StepLoad<Dim>& load, std::vector<Real>& residual, Lift* lift);
  void assemble_loads(const std::vector<Real>& u, const StepLoad<Dim>& load, std::vector<Real>& residual, Lift* lift);
  /// What work(cell, residual, matrix) adds at some cells, by functions and components of each.
  template <class Acts, class Work>
  void assemble_cells(const std::vector<Real>& u, const StepLoad<Dim>& load, std::vector<Real>& residual, Lift* lift, Acts&& acts,
                      Work&& work);
  void assemble_contact(const std::vector<Real>& u, const StepLoad<Dim>& load, std::vector<Real>& residual, Lift* lift);
  void assemble_faces(const std::vector<Real>& u, const StepLoad<Dim>& load, std::vector<Real>& residual, Lift* lift);
  /// The matrix of some nodes into the sparse one; `offsets` by pair (I, K): place of I's rows in the columns of K.
  void scatter(const int* nodes, std::size_t count, const int* offsets, const Real* K, Lift& lift);
  /// Adds the friction on nodes to their residual and their matrix, if there is one.
  void add_friction(const int* nodes, std::size_t count, const std::vector<Real>& u, const StepLoad<Dim>& load, Real* residual,
                    Real* K) const;
  void project_volumes(std::vector<Real>& A) const;
  void work_patch(const VolumePatch<Dim>& patch, const std::vector<Real>& u, const StepLoad<Dim>& load, std::vector<Real>& residual,
                  std::vector<Real>* K) const;
  void assemble_patches(const std::vector<Real>& u, const StepLoad<Dim>& load, std::vector<Real>& residual, Lift* lift);
  std::size_t width() const { return static_cast<std::size_t>(space_.functions() * Dim); }

  /// Of one source.
  struct Law {
    TangentFunction<Dim> evaluate;
    const void* data;
    Real soft_modulus;  ///< Shear modulus that the soft stiffness is a share of [Pa].
    Real weight_ratio;
  };
  const StepSpace<Dim>& space_;
  BodyContact<Dim>& contact_;
  const SideContact<Dim>& sides_;
  PointLoads<Dim>& loads_;
  VolumePatches<Dim> patches_;
  std::vector<Law> laws_;
  Real surface_penalty_;
  std::vector<SurfaceFace<Dim>> faces_;

  SparseMatrix matrix_;
  Index pattern_ = 0;
  Index space_pattern_ = -1;
  Index contact_pattern_ = -1;
  std::vector<int> first_unknown_;  ///< Per active node: unknowns before it.
  std::vector<int> row_offset_;     ///< Per cell and pair of its nodes (I, K): place of I's rows in the columns of K.
  std::vector<int> soft_cells_;     ///< Per cell: place in soft_stiffness_, or -1.
  std::vector<Real> soft_stiffness_;
  std::vector<Real> cell_matrices_;
  std::vector<Real> cell_residuals_;
};

}  // namespace matpoint
