// Regions, layouts and velocity fields as they stand in a case file.
#pragma once

#include <gtest/gtest.h>

#include "case/case_file.hpp"
#include "geometry/layout.hpp"
#include "geometry/velocity_field.hpp"

namespace matpoint::test {

/// `text` is what follows the equals sign: "{ type = \"disk\", ... }".
template <class Base>
std::shared_ptr<Base> from_toml(const TypeRegistry<Base>& registry, const std::string& text, int dim, const std::string& what) {
  return registry.read(*parse_toml("x = " + text, "a.toml").find("x"), {dim, ""}, what);
}
inline RegionPointer region(const std::string& text, int dim = 2) { return from_toml(region_registry(), text, dim, "region"); }
inline std::shared_ptr<Layout> layout(const std::string& text, int dim = 2) { return from_toml(layout_registry(), text, dim, "layout"); }
inline std::shared_ptr<VelocityField> velocity_field(const std::string& text, int dim = 2) {
  return from_toml(velocity_registry(), text, dim, "velocity");
}

/// The text of the InputError that f throws, or nothing.
template <class F>
std::string complaint_of(F&& f) {
  try {
    f();
    return {};
  } catch (const InputError& error) {
    return error.what();
  }
}

}  // namespace matpoint::test
