// What the readers of a case's sections share.
#pragma once

#include <algorithm>

#include "core/parameters.hpp"

namespace matpoint {

/// The given value, for the place of a message; the table itself when the key is absent.
inline const Input& at_key(const Input& table, const std::string& key) {
  const Input* value = table.find(key);
  return value != nullptr ? *value : table;
}

inline bool is_given(const Input& table, const std::string& key) { return table.find(key) != nullptr; }

inline void check_words(const std::vector<std::string>& given, const std::string& key, const std::vector<std::string>& allowed,
                        const Input& table, const ReadContext& context) {
  for (const std::string& word : given) {
    if (std::find(allowed.begin(), allowed.end(), word) != allowed.end()) continue;
    fail_input(at_key(table, key), context,
               fmt::format("{}: \"{}\" is unknown, allowed: {}{}", key, word, list_names(allowed), did_you_mean(word, allowed)));
  }
}

inline std::vector<std::string> axis_names(int dim) {
  return dim == 2 ? std::vector<std::string>{"x", "y"} : std::vector<std::string>{"x", "y", "z"};
}

inline std::vector<std::string> side_names(int dim) {
  std::vector<std::string> names = {"left", "right", "bottom", "top"};
  if (dim == 3) names.insert(names.end(), {"front", "back"});
  return names;
}

/// Something chosen by `type` from a registry.
template <class Owner, class Base>
void typed(ParameterTable<Owner>& table, const std::string& name, std::shared_ptr<Base> Owner::*member,
           const TypeRegistry<Base>& (*registry)(), const std::string& help, bool is_required) {
  table.custom(
      {name, "1", "table with a type", "", list_names(registry().names()), help, is_required},
      [=](Owner& owner, const Input& input, const ReadContext& context) { owner.*member = registry().read(input, context, name); },
      [=](const Owner& owner, int dim) -> std::optional<Input> {
        if (!(owner.*member)) return std::nullopt;
        return (owner.*member)->write(dim);
      });
}

}  // namespace matpoint
