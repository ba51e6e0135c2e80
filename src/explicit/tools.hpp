// Rigid tools and the particles that they touch.
//
// A particle ends half a spacing h before its middle, by its volume. Where a tool's surface is nearer, by the overlap o, they push each
// other along the surface's normal with the force of the potential
//
//     Phi = sum_p 1/2 k_p o_p^2,     k_p = s K V_p / h^2,     K = rho c^2 of the material, s the tool's `stiffness`,
//
// so that a pressure p makes an overlap of p h / (s K). With s = 1 a column that is pressed between a tool and a side is as stiff as one of
// its length, to 0.2 % (0.96 with 1/2, 1.02 with 2): what the surface gives is what the particles' half spacings would. A dashpot
// beside each spring, which only pushes, too, calms what rests. They rub with Coulomb's law. Forces are equal and opposite, their moments,
// too: what bodies and tools have of momentum together stays to rounding. Particles feel a tool where its surface is, and not where the
// grid's nodes are.
#pragma once

#include <functional>

#include "body/body.hpp"
#include "case/case.hpp"
#include "explicit/rigid_motion.hpp"

namespace matpoint {

template <int Dim>
class Tools {
 public:
  /// The bodies, in the order of the case and as they start, must outlive this. Throws InputError for particles in a tool.
  Tools(const Case& problem, std::vector<const Body<Dim>*> bodies);

  /// Moves the tools from time t to t + dt, under the forces of the last update. Particles have been moved to t + dt, too.
  void advance(Real t, Real dt, const Vec3& gravity);
  /// Evaluates the forces where all are now, dt [s] after the last time, and books what they have done since, for which `since` is 0 where
  /// the particles have been moved other than by a step.
  void update(Real dt, Real since, Ledger& ledger);

  const ParticleForces<Dim>& forces(std::size_t body) const { return touched_[body].forces; }
  /// From the surface of the nearest one [m]; negative inside.
  Real distance(const Vec3& x) const;
  /// Stored in the overlaps now [J].
  Real energy() const { return energy_; }
  /// Largest stable step [s].
  Real stable_dt() const;
  const std::vector<BoundaryTotals>& totals() const { return totals_; }
  std::vector<StepNumber> numbers() const;
  void declare_state(State& state);

 private:
  struct Tool {
    std::string name;
    RegionPointer shape;
    RigidMotion motion;
    Real friction;
    Real stiffness;
    Vec3 force{};      ///< On it [N],
    Vec3 torque{};     ///< and about its pivot [N m].
    Real overlap = 0;  ///< The greatest, over half a spacing [1].
    Real k_sum = 0;    ///< Stiffness of all that touches [N/m].
    Vec3 way{};        ///< Of the pivot in the last step [m],
    Vec3 turn{};       ///< and about it [rad].
  };
  /// What is known of a body's particles.
  struct Touched {
    const Body<Dim>* body;
    Real modulus;              ///< [Pa]
    std::vector<Real> mass;    ///< By id [kg].
    std::vector<Real> volume;  ///< At the start, by id.
    std::vector<Real> half;    ///< Half a spacing, by id [m].
    /// By tool and id, of those that lie nearer at the start: where they touch [m].
    std::vector<std::vector<std::pair<Index, Real>>> laid;
    ParticleForces<Dim> forces;
    ParticleForces<Dim> last_forces;
    /// Where a particle near a tool was, and at which update; by id, now and at the last update.
    struct Place {
      Index update = -1;
      Vec<Dim> x{};  ///< [m]
    };
    std::vector<Place> places, last_places;
    /// How deep a particle lies in a tool.
    struct Touch {
      Index id = -1;
      Real overlap = 0;  ///< [m]
      void declare_state(State& state) {
        state.add("id", id);
        state.add("overlap", overlap);
      }
    };
    /// By tool, ascending ids: now, and at the update before.
    std::vector<std::vector<Touch>> touches, last_touches;
    /// Of a particle that touched a tool then, too; otherwise `overlap`.
    Real last_overlap(std::size_t tool, Index id, Real overlap) const;
    Real reach(std::size_t tool, Index id) const;
  };
  Extent<Dim> box_of(const Tool& tool, Real margin) const;
  void touch(std::size_t tool, Touched& body, Real dt);
  /// Of the forces, as a mean over the step, in the ways of the particles since the last update [J].
  Real work_on(const Touched& body) const;

  std::vector<Tool> tools_;
  std::vector<Touched> touched_;
  std::vector<BoundaryTotals> totals_;
  Real energy_ = 0;
  Real last_dt_ = 0;
  Index number_ = 0;    ///< Of this update.
  Extent<Dim> grid_{};  ///< Its box [m].
  Real half_min_ = 0;   ///< The smallest half spacing [m].
  Real k_over_m_ = 0;   ///< The greatest stiffness over mass of a particle [1/s^2].
};

}  // namespace matpoint
