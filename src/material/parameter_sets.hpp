// Materials by name: parameters from the literature, for `material = "copper_ofhc"`.
#pragma once

#include <string>
#include <vector>

#include "core/parameters.hpp"

namespace matpoint {

struct ParameterSet {
  std::string name;
  std::string summary;  ///< One line, with the source.
  Input table;          ///< As in a case file.
};

const std::vector<ParameterSet>& parameter_sets();

/// A material's table: `input` itself, or the parameter set that it names. Throws InputError for an unknown name.
Input material_table(const Input& input, const ReadContext& context);

}  // namespace matpoint
