// The sections [[load]] of a case: forces on the particles of a body.
#pragma once

#include "case/body_spec.hpp"

namespace matpoint {

enum class LoadKind { pressure, traction, force };

struct LoadSpec {
  std::string name;  ///< In results; load_names where none is given.
  std::string body;
  LoadKind kind = LoadKind::force;
  Real pressure = 0;           ///< [Pa]; follows the surface.
  std::vector<Real> traction;  ///< [Pa], dim numbers; per undeformed area, keeps its direction.
  std::vector<Real> force;     ///< [N], dim numbers; of all of it.
  std::string side;            ///< Of the body, where its surface looks that way; empty: all sides.
  RegionPointer region;        ///< Null: everywhere.
  std::vector<Real> times;     ///< [s], with factors: a table in time, linear between, constant outside.
  std::vector<Real> factors;   ///< [1]
  std::string place;
  /// Whether it acts on the surface, or on the particles in a region by their mass.
  bool is_on_surface() const { return kind != LoadKind::force || !side.empty(); }
  static void declare(ParameterTable<LoadSpec>& table);
};

/// What goes beyond single values. Throws InputError.
void check_load(LoadSpec& load, const Input& input, const ReadContext& context);

/// The names of loads in results: as given, or "load_1" and so on.
std::vector<std::string> load_names(const std::vector<LoadSpec>& loads);

}  // namespace matpoint
