// A material is one constitutive law with its parameters. The law's author writes a pointwise function templated on its scalar
// (law.hpp says how); this is its face at run time, called once per body or block of particles and never per particle.
#pragma once

#include <memory>

#include "core/parameters.hpp"
#include "core/types.hpp"

namespace matpoint {

/// A run of material points of one body, as pointers into the storage of its fields: entry i of every array belongs to point i.
/// Second-order tensors of F and L are dim x dim, row by row; the law completes them to 3x3 (plane strain in 2D: F33 = 1, L33 = 0).
struct PointBlock {
  Index count = 0;
  Real dt = 0;                ///< Time step [s].
  Real* F[9] = {};            ///< In: F_n. Out: F_n+1 = (I + L dt) F_n [1].
  const Real* L[9] = {};      ///< Velocity gradient [1/s].
  Real* tau[6] = {};          ///< Out: Kirchhoff stress J sigma [Pa]; xx yy zz xy (yz xz in 3D).
  const Real* volume0 = {};   ///< Reference volume [m^3].
  Real* const* history = {};  ///< The law's history, one array per scalar.
  Real dissipated = 0;        ///< Out: viscous dissipation in this step, summed over the points [J].
  Index first_inverted = -1;  ///< Out: the first point whose det F is not positive and finite, or -1.
};

class Material {
 public:
  virtual ~Material() = default;

  virtual std::string type() const = 0;
  virtual Real density() const = 0;  ///< Reference density [kg/m^3].
  virtual Index history_size() const = 0;

  /// F <- (I + L dt) F and the new stress and history, for points of a body in `dim` dimensions.
  virtual void update(PointBlock& block, int dim) const = 0;

  /// Energy stored per reference volume [J/m^3] at the deformation gradient F (3x3, row by row); 0 for a law without one.
  virtual Real energy_density(const std::array<Real, 9>& F) const = 0;

  /// Speed of pressure waves [m/s] at volume ratio J [1], for the stable time step.
  virtual Real wave_speed(Real J) const = 0;
  /// Kinematic viscosity [m^2/s] that limits an explicit step to h^2 / (2 dim nu); 0 for a law without viscosity.
  virtual Real kinematic_viscosity(Real J) const = 0;

  /// The parameters with the key `type`, as in a case file.
  virtual Input write(int dim) const = 0;
};

/// All laws that case files and Python can name. A new law adds its name to laws.hpp.
const TypeRegistry<Material>& material_registry();

}  // namespace matpoint
