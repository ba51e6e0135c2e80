// Contact between bodies by forces between pairs of particles: it asks for places only, and so also serves total Lagrangian bodies, which
// never meet on the grid.
//
// The idea of forces between near particles of different bodies is de Vaucorbeil & Nguyen's (Modelling contacts with a total Lagrangian
// material point method, CMAME 2021), who let every particle be a disc of half a spacing. Lattices of discs are rough: two flat bodies
// that slide rise and fall by 0.13 spacings in 2D. Here a particle feels instead how much of the other body is around it,
//
//     c_p = sum_q V_q W(|x_p - x_q|),     W = alpha (1 - d^2 / R^2)^4 for d < R = 2.5 spacings,  integral 1,
//
// a smooth fraction of volume: 0 far away, 1 inside. Where flat surfaces touch, p is half a spacing away from the other body and c_p is
// c0_p, the sum over rows of particles beyond a plane at that distance. What is more presses:
//
//     Phi = sum_p V_p K / 2 <c_p - c0_p>^2     over the particles of both bodies,     F = -dPhi/dx.
//
// Phi depends on distances only. So the force of each pair is central, equal and opposite; energy, momentum and angular momentum are kept.
// Lattices that slide on each other rise and fall by 0.001 spacings.
//
// Sides with kind = "slip" are planes of symmetry: the images of the other body's particles count, too.
//
// Friction: p moves along the surface against the mean of its neighbours of the other body, weighted as in c_p. A spring keeps that
// displacement, gives way where it pulls harder than mu times the normal force of p's own share of Phi (Cundall & Strack 1979), and pulls
// p one way and the neighbours, with the same weights, the other. Dashpots beside the springs, along and across, calm what rubs.
#pragma once

#include <memory>
#include <vector>

#include "body/body.hpp"
#include "body/mirror_image.hpp"
#include "case/case.hpp"
#include "geometry/pair_kernel.hpp"

namespace matpoint {

template <int Dim>
class PairContact {
 public:
  /// The bodies must outlive this, in the order of the case.
  PairContact(const Case& problem, std::vector<const Body<Dim>*> bodies);
  ~PairContact();

  /// Evaluates the forces where the particles are now, dt [s] after the last time. In between, particles have moved by steps only.
  void update(Real dt);
  /// Particles have been moved or taken away other than by steps.
  void forget_places();
  /// On the particles of a body.
  using Forces = ParticleForces<Dim>;
  const Forces& forces(std::size_t body) const;
  /// Stored now: in the overlap, and in the springs of particles that stick [J].
  Real energy() const { return energy_; }
  /// By friction, in the last update [J].
  Real dissipated() const { return dissipated_; }
  /// Largest stable step [s], of two surfaces against each other.
  Real stable_dt() const { return stable_dt_; }
  void declare_state(State& state);

 private:
  struct Points;
  struct Participant;
  struct Pair;
  /// The spring of a particle that rubs.
  struct Hold {
    Index id = -1;
    Vec<Dim> pulled{};  ///< Along the surface [m].
    Real energy = 0;    ///< [J]
    void declare_state(State& state) {
      state.add("id", id);
      state.add("pulled", pulled);
      state.add("energy", energy);
    }
  };

  static Real reach_of(const Pair& pair);
  void search();
  void meet(Pair& pair, Real dt);
  void lay(Pair& pair, const Participant (&sides)[2]);
  void rub(Pair& pair, Participant (&sides)[2], Real dt);
  void let_go(Pair& pair, std::array<std::vector<Hold>, 2> holds);
  void add_forces(const Participant& side);

  std::vector<Points> points_;
  std::vector<Pair> pairs_;
  std::vector<MirrorImage<Dim>> images_;
  Real friction_;
  bool is_first_ = true;  ///< No update yet.
  Real free_way_ = 0;     ///< So far two particles may approach each other before the next search [m].
  Real energy_ = 0;
  Real dissipated_ = 0;
  Real stable_dt_ = 0;
};

}  // namespace matpoint
