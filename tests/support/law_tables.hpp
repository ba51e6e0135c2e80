// Parameters for a law that nobody has told us about, from its declaration.
#pragma once

#include <gtest/gtest.h>

#include <functional>

#include "core/parameters.hpp"

namespace matpoint::test {

/// A value that the parameter may have, from its unit; `set` picks among several. Numbers without a unit can mean anything, so the
/// first of a list that the declaration allows is taken.
inline std::vector<Real> candidates(const ParameterDescription& parameter, int set, std::size_t position) {
  const Real spread = 1 + 0.37 * static_cast<Real>(position) + 0.5 * set;
  if (parameter.unit == "kg/m^3") return {1200 * spread};
  if (parameter.unit == "Pa") return {2e4 * spread};
  if (parameter.unit == "Pa s") return {30 * spread};
  if (parameter.unit == "deg") return {30 - static_cast<Real>(position)};
  if (parameter.name == "Jm") return {30 * spread};  // a limit of stretch is far from where it is sampled
  if (parameter.name.starts_with("alpha_")) return {1.1 * spread};
  const Real rising = 1 + 0.1 * static_cast<Real>(position);
  if (set == 0) return {0.3 * rising, 1.4, 3, 7};
  return {-0.25, 0.2 * rising, 2, 7};
}

/// A table of parameters that `read` accepts, made from their declarations: all given (sets 0 and 1), or the required ones only (set 2).
inline Input sample_table(const std::vector<ParameterDescription>& parameters, int set, const std::function<void(const Input&)>& read,
                          Input table = Input::table()) {
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const ParameterDescription& parameter = parameters[k];
    if ((set == 2 && !parameter.is_required) || parameter.type == "string") continue;
    bool is_allowed = false;
    for (const Real value : candidates(parameter, set, k)) {
      table.set(parameter.name, Input::real(value));
      try {
        read(table);
        is_allowed = true;
      } catch (const InputError& error) {
        // The parameters after this one are still to come.
        is_allowed = std::string(error.what()).find("is missing") != std::string::npos;
      }
      if (is_allowed) break;
    }
    if (!is_allowed && !parameter.is_required) {
      table.entries().pop_back();  // it may be one that excludes another
      continue;
    }
    if (!is_allowed) ADD_FAILURE() << "give candidates() a value for " << parameter.name << " [" << parameter.unit << "]";
  }
  return table;
}

}  // namespace matpoint::test
