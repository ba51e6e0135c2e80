// A load on the particles of a body: which of them carry it, and what it does to them as they deform.
//
// A particle beside the surface carries the load on the free faces of its box (geometry/seed_surface.hpp). A face with the area A, the
// normal n and the arm X from the particle's middle, all at the start, has the force t A under a traction t, or -p cof(F) n A under a
// pressure p, by the area that it has now (Nanson). It acts where the face is, at x_p + F X:
//
//     f_i = sum over faces of  force N_i(x_p + F X),
//
// with the functions of the particle's own cell, which reach beyond it: so forces and moments are those of the load on the surface itself,
// and what the stresses of the particles in a cut cell do at its nodes balances them; but nodes that the body's own particles do not reach,
// and that have no mass, get nothing. That is the trouble of loads on surfaces that move through a grid, which others mend by stresses
// that end at the surface (Given, Liang, Zeng, Zhang & Soga 2024).
#pragma once

#include "case/case.hpp"
#include "geometry/layout.hpp"

namespace matpoint {

/// A force beside a particle.
template <int Dim>
struct PointForce {
  Vec<Dim> force{};  ///< [N]
  Vec<Dim> arm{};    ///< From the particle to it, at the start [m].
};

/// The cofactors det(F) F^-T of a Dim x Dim matrix, row by row.
template <int Dim>
std::array<Real, Dim * Dim> cofactors(const Real* F);

template <int Dim>
class ParticleLoad {
 public:
  /// Throws InputError where it has no particles.
  ParticleLoad(const Case& problem, std::size_t load, const SeedingGrid& grid);

  const std::string& name() const { return name_; }
  std::size_t body() const { return body_; }
  bool follows() const { return spec_.kind == LoadKind::pressure; }
  /// Those that carry it, ascending.
  const std::vector<Index>& ids() const { return ids_; }
  /// Whose particles start with deformation gradients: Dim x Dim numbers each, in the order of ids(), and F33.
  void refer_to(const std::vector<Real>& F, const std::vector<Real>& F33);
  /// Of the k-th of ids(), the first of its faces; of one more, their number.
  std::size_t first_face(std::size_t k) const { return first_face_[k]; }
  /// On a face, with the load's factor, of a particle with the deformation gradient F, Dim x Dim numbers.
  PointForce<Dim> on(std::size_t face, Real factor, const Real* F, Real F33) const;

 private:
  struct Face {
    Vec<Dim> area{};  ///< n A [m^2]
    Real size = 0;    ///< A [m^2], or the share of a force [1].
    Vec<Dim> arm{};   ///< X [m]
  };
  LoadSpec spec_;
  std::string name_;
  std::size_t body_ = 0;
  std::vector<Index> ids_;
  std::vector<std::size_t> first_face_;
  std::vector<Face> faces_;
};

/// All loads of a case.
template <int Dim>
std::vector<ParticleLoad<Dim>> particle_loads(const Case& problem, const SeedingGrid& grid);

}  // namespace matpoint
