// The sections [[boundary]] of a case: conditions on the grid's nodes.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "core/parameters.hpp"
#include "geometry/region.hpp"
#include "geometry/velocity_field.hpp"

namespace matpoint {

enum class BoundaryKind { fixed, slip, velocity, traction };

/// A velocity [m/s] as a function of time [s]; programs can give one, case files have tables instead.
struct VelocityHistory {
  std::function<Vec3(Real)> at;
};

/// What a condition prescribes at a time: one velocity everywhere, or one by place.
struct PrescribedVelocity {
  Vec3 everywhere{};                     ///< [m/s], without a field.
  const VelocityField* field = nullptr;  ///< Of the condition, which it must not outlive.
  Real factor = 1;                       ///< Of the field.
  Vec3 at(const Vec3& x) const;
  /// From what stands for a velocity with Dim numbers.
  template <std::size_t Dim>
  std::array<Real, Dim> at(const std::array<Real, Dim>& x) const {
    Vec3 place{};
    if (field != nullptr) std::copy(x.begin(), x.end(), place.begin());
    const Vec3 v = at(place);
    std::array<Real, Dim> result;
    std::copy_n(v.begin(), Dim, result.begin());
    return result;
  }
};

/// How a rigid face holds what touches it: for good; only as long as it presses; or as long as it presses, and along the face no harder
/// than Coulomb's law allows.
enum class FaceContact { stick, no_tension, friction };
/// Of a side in the implicit solver: what touches it, nodes that reach the body or the particles' surfaces.
enum class ContactBy { nodes, particles };

/// A condition on the grid's nodes: on one side of the grid, or in a region.
struct BoundarySpec {
  std::string name;  ///< In results, where one is given (boundary_names).
  std::string side;  ///< left right bottom top (front back in 3D); empty when a region is given.
  RegionPointer region;
  BoundaryKind kind = BoundaryKind::slip;
  std::vector<std::string> components;            ///< Fixed components of `fixed` and `velocity`; empty: all.
  std::vector<Real> velocity;                     ///< [m/s], dim numbers, for kind = "velocity".
  std::vector<Real> traction;                     ///< [Pa], dim numbers, for kind = "traction".
  std::shared_ptr<VelocityField> velocity_field;  ///< Instead: by place.
  std::vector<Real> times;                        ///< [s], with velocities or factors: a table in time, linear between, constant outside.
  std::vector<Vec3> velocities;                   ///< [m/s], one per time.
  std::vector<Real> factors;                      ///< Of the velocity, one per time [1].
  std::shared_ptr<VelocityHistory> velocity_history;
  bool is_attached = false;
  Real receding_correction = 0;  ///< C_c [1]
  FaceContact contact = FaceContact::stick;
  Real friction = 0;  ///< Coulomb's coefficient of contact = "friction" [1].
  std::optional<ContactBy> contact_by;
  /// Where none is given: particles, for they touch at the right place; but nodes with friction, which calm what rubs.
  bool touches_by_particles() const {
    return contact != FaceContact::stick &&
           contact_by.value_or(contact == FaceContact::friction ? ContactBy::nodes : ContactBy::particles) == ContactBy::particles;
  }
  std::string place;
  static void declare(ParameterTable<BoundarySpec>& table);
};

/// A side of the grid.
struct BoundarySide {
  int axis;
  bool is_upper;
};
BoundarySide side_of(const std::string& name);

/// The velocity that a condition prescribes at time t; 0 unless kind = "velocity".
PrescribedVelocity velocity_at(const BoundarySpec& spec, Real t);

/// The names of boundaries in results: as given, or of the side, or of the place in the list where the side has more than one. Throws
/// InputError for two that are the same.
std::vector<std::string> boundary_names(const std::vector<BoundarySpec>& boundaries);

/// What goes beyond single values. Throws InputError.
void check_boundary(BoundarySpec& boundary, const Input& input, const ReadContext& context);

}  // namespace matpoint
