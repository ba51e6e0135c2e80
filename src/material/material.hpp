// A material is one constitutive law with its parameters. The law's author writes a pointwise function templated on its scalar
// (law.hpp says how); this is its face at run time. The solver does not call it per particle: it takes the law's kernel, once.
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "core/parameters.hpp"
#include "core/types.hpp"

namespace matpoint {

/// Name and unit of a number that a law remembers, as it appears in the output.
struct InternalVariable {
  const char* name;
  const char* unit;
  Real at_rest = 0;  ///< Outputs show what is remembered, which is 0 at rest, on top of this.
};

class Material {
 public:
  /// A 3 x 3 matrix, row by row.
  using Matrix = std::array<Real, 9>;

  virtual ~Material() = default;

  virtual std::string type() const = 0;
  virtual Real density() const = 0;             ///< Reference density [kg/m^3].
  virtual int history_size(int dim) const = 0;  ///< Numbers per point that the law remembers.
  /// Whether the stress depends on more than F and the history.
  virtual bool is_rate_dependent() const = 0;
  /// Whether stress and energy follow from F and the history (law.hpp).
  virtual bool has_state() const { return false; }
  /// Whether it remembers its elastic strain, so that F may count from any state.
  virtual bool remembers_strain() const { return false; }
  /// Whether what it dissipates is plastic, or goes into breaking, and not viscous.
  virtual bool is_plastic() const { return false; }
  /// Whether what it describes flows without limit, as soils, grains and muds do.
  virtual bool flows_freely() const { return false; }
  /// Whether the derivative of a step's stress is symmetric.
  virtual bool is_symmetric() const = 0;
  /// What it remembers and outputs know by a name: the last numbers of the history.
  virtual std::vector<InternalVariable> internal_variables() const { return {}; }

  /// Whether the law branches, so that its kernel works one point after the other.
  virtual bool is_scalar_only() const = 0;
  /// Whether the stress knows of F only J, so that a body may forget its shape (law.hpp).
  virtual bool is_fluid() const = 0;
  /// Whether it is a fluid with an energy of its own, whose volume changes as it may.
  bool is_gas() const { return is_fluid() && has_state(); }

  /// Whether it may break: then it has a damage.
  bool breaks() const {
    const std::vector<InternalVariable> variables = internal_variables();
    return std::any_of(variables.begin(), variables.end(),
                       [](const InternalVariable& one) { return one.name == std::string_view("damage"); });
  }

  /// The law's place in AllLaws, for its kernel, or -1 for a FunctionMaterial; and the law itself, for the kernel to read.
  virtual int law_index() const = 0;
  virtual const void* law_data() const = 0;

  /// Kirchhoff stress [Pa] at the deformation gradient F, at rest; of a law with a state, with its history where that is given, else where
  /// it was brought to F elastically.
  virtual Matrix kirchhoff_stress(const Matrix& F, std::span<const Real> history = {}) const = 0;
  /// Energy stored per reference volume [J/m^3], of the same; 0 for a law without one.
  virtual Real energy_density(const Matrix& F, std::span<const Real> history = {}) const = 0;
  /// The history of a point that was brought to F elastically; what else it remembers stays. Only for laws with a state.
  virtual void deform_history(const Matrix& /*F*/, std::span<Real> /*history*/) const {}

  /// Whether it remembers the greatest pressure that it carried; and its history where that is `ratio` times the present one.
  virtual bool consolidates() const { return false; }
  virtual void consolidate(std::span<Real> /*history*/, Real /*ratio*/) const {}

  /// Speed of pressure waves [m/s] at volume ratio J [1], for the stable time step.
  virtual Real wave_speed(Real J) const = 0;
  /// Whether it has a `length` that is to be the cell size, since none is given; and the same material with that length. Throws InputError
  /// at `place` for a length that its other parameters do not allow.
  virtual bool needs_length() const { return false; }
  virtual std::shared_ptr<Material> with_length(Real /*length*/, const Input& /*place*/, const ReadContext& /*context*/) const {
    return nullptr;
  }
  /// Whether waves become faster than that as the material hardens; and then the greatest rho0 c^2 [Pa] of a state.
  virtual bool has_wave_modulus() const { return false; }
  virtual Real wave_modulus(const Matrix& /*F*/, std::span<const Real> /*history*/) const { return 0; }
  /// Kinematic viscosity [m^2/s] that limits an explicit step to h^2 / (2 dim nu); 0 for a law without viscosity.
  virtual Real kinematic_viscosity(Real J) const = 0;

  /// The parameters with the key `type`, as in a case file.
  virtual Input write(int dim) const = 0;
};

/// xx yy zz xy yz xz of a symmetric matrix.
inline std::array<Real, 6> components_of(const Material::Matrix& m) { return {m[0], m[4], m[8], m[1], m[5], m[2]}; }

/// All laws that case files and Python can name. A new law adds its name to laws.hpp.
const TypeRegistry<Material>& material_registry();

/// What they remember and outputs can name, with the laws that do.
const std::map<std::string, std::vector<std::string>>& material_variables();

}  // namespace matpoint
