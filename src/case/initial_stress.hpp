// Stresses that a body starts with, as functions of the position: soil carries its own weight before anything happens.
#pragma once

#include <memory>
#include <optional>

#include "core/parameters.hpp"

namespace matpoint {

struct BodySpec;
struct Case;

class InitialStress {
 public:
  virtual ~InitialStress() = default;
  /// Cauchy stress [Pa] at the position x [m], tension positive: xx yy zz xy yz xz.
  virtual std::array<Real, 6> at(const Vec3& x) const = 0;
  virtual Input write(int dim) const = 0;
  virtual void check(const Input&, const ReadContext&) const {}
  /// What only the whole case knows. `body` has this stress. Throws InputError.
  virtual void resolve(const Case& /*problem*/, const BodySpec& /*body*/) {}

  /// Times the pressure that it carries is the greatest one it has carried; empty: what the material says.
  std::optional<Real> overconsolidation;
};

/// uniform, geostatic, table.
const TypeRegistry<InitialStress>& initial_stress_registry();

/// Of all bodies, when the case has been read; refuses what cannot start with a stress. Throws InputError.
void resolve_initial_stresses(Case& problem);

}  // namespace matpoint
