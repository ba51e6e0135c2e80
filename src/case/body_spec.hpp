// The sections [[body]] of a case.
#pragma once

#include <memory>
#include <optional>

#include "case/initial_stress.hpp"
#include "core/parameters.hpp"
#include "geometry/layout.hpp"
#include "geometry/region.hpp"
#include "geometry/velocity_field.hpp"
#include "material/material.hpp"

namespace matpoint {

/// Where shape functions are taken: at the particles' places now, or in the reference configuration.
enum class Formulation { updated, total };

/// What a body consists of.
enum class BodyMethod { particles, elements };

struct BodySpec {
  std::string name;
  BodyMethod method = BodyMethod::particles;
  Formulation formulation = Formulation::updated;
  /// The volume changes as the mean of a cell, or of a patch of cells, does; chosen by choose_scheme where it is not given.
  std::optional<bool> fbar;
  bool has_fbar() const { return fbar.value_or(false); }
  bool keeps_displacement = false;  ///< Particles know where they started; of `output.fields`.
  RegionPointer region;
  std::shared_ptr<Layout> layout;
  std::shared_ptr<VelocityField> velocity;  ///< Null: at rest.
  std::shared_ptr<Material> material;
  std::shared_ptr<InitialStress> initial_stress;  ///< Null: none but what the material has at rest.
  std::optional<Real> weight_density;  ///< Of a body of elements: what gravity acts on [kg/m^3]; without it the material's density.
  Real receding_correction = 0;        ///< Of a body of elements: C_c of its faces [1].
  std::string place;                   ///< Where the body stands in the case file, for messages.
  static void declare(ParameterTable<BodySpec>& table);
};

/// "case.toml:7: body "disk"", for messages.
std::string place_of(const BodySpec& body);

/// What goes beyond single values. Throws InputError.
void check_body(BodySpec& body, const Input& input, const ReadContext& context);

}  // namespace matpoint
