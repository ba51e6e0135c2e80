// Case files: TOML in, TOML out. The only file that knows TOML.
#pragma once

#include <map>

#include "case/case.hpp"

namespace matpoint {

/// Parses TOML text into a tree of values with places "<file>:<line>". Throws InputError with the line for bad syntax.
Input parse_toml(const std::string& text, const std::string& file);

/// Writes a tree as TOML text that parse_toml reads back to the same values, bit for bit.
std::string write_toml(const Input& input);

/// Applies "key.path=value" (bodies and probes by name or number) to the tree. Throws InputError.
void apply_set(Input& input, const std::string& assignment);

/// The text of a case file, or of a shipped case when no such file exists and `name` is one. Throws InputError.
struct CaseText {
  std::string text;
  std::string file;  ///< For messages.
  std::string name;  ///< The stem.
};
CaseText find_case(const std::string& name);

/// find_case, parse_toml, apply_set for each of `sets`, Case::from_input.
Case load_case(const std::string& name, const std::vector<std::string>& sets = {});

/// The cases that come with matpoint, embedded in the program: name and text.
const std::map<std::string, std::string>& shipped_cases();

}  // namespace matpoint
