// One declaration per parameter: its name, unit, default, allowed range and help stand once, and feed the reader, the messages,
// `matpoint explain`, the resolved case in the manifest and the docs.
//
//   static void declare(ParameterTable<NeoHookean>& table) {
//     table.required("density", "kg/m^3", &NeoHookean::density, positive(), "Mass per reference volume.");
//     table.optional("gamma", "1", &NeoHookean::gamma, at_least(1), "...");       // the default is the member's initialiser
//   }
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <type_traits>

#include "core/error.hpp"
#include "core/input.hpp"

namespace matpoint {

/// What a number may be; `text` completes "is ..., allowed: ".
struct Constraint {
  std::string text;
  std::function<bool(Real)> holds;
};

Constraint any_number();
Constraint positive();
Constraint non_negative();
Constraint at_least(Real lower);
Constraint between(Real lower, Real upper);         ///< lower < value < upper
Constraint between_closed(Real lower, Real upper);  ///< lower <= value <= upper

/// What a reader needs to know about its surroundings: the dimension of the case and the words that name the place.
struct ReadContext {
  int dim = 2;
  std::string where;
};

/// Throws InputError("<file:line>: <where>: <text>").
[[noreturn]] void fail_input(const Input& input, const ReadContext& context, const std::string& text);

struct ParameterDescription {
  std::string name;
  std::string unit;
  std::string type;
  std::string default_text;
  std::string allowed;
  std::string help;
  bool is_required = false;
};

void read_value(const Input&, const ReadContext&, const std::string& name, const Constraint&, bool&);
void read_value(const Input&, const ReadContext&, const std::string& name, const Constraint&, int&);
void read_value(const Input&, const ReadContext&, const std::string& name, const Constraint&, Index&);
void read_value(const Input&, const ReadContext&, const std::string& name, const Constraint&, Real&);
void read_value(const Input&, const ReadContext&, const std::string& name, const Constraint&, std::string&);
/// A point or vector with `dim` numbers.
void read_value(const Input&, const ReadContext&, const std::string& name, const Constraint&, Vec3&);
/// A number, or an array of numbers.
void read_value(const Input&, const ReadContext&, const std::string& name, const Constraint&, std::vector<Real>&);
void read_value(const Input&, const ReadContext&, const std::string& name, const Constraint&, std::vector<int>&);
void read_value(const Input&, const ReadContext&, const std::string& name, const Constraint&, std::vector<std::string>&);
/// An array of points.
void read_value(const Input&, const ReadContext&, const std::string& name, const Constraint&, std::vector<Vec3>&);

template <class U>
void read_value(const Input& input, const ReadContext& context, const std::string& name, const Constraint& constraint,
                std::optional<U>& value) {
  U given{};
  read_value(input, context, name, constraint, given);
  value = std::move(given);
}

Input write_value(bool, int dim);
Input write_value(int, int dim);
Input write_value(Index, int dim);
Input write_value(Real, int dim);
Input write_value(const std::string&, int dim);
Input write_value(const Vec3&, int dim);
Input write_value(const std::vector<Real>&, int dim);
Input write_value(const std::vector<int>&, int dim);
Input write_value(const std::vector<std::string>&, int dim);
Input write_value(const std::vector<Vec3>&, int dim);

template <class U>
constexpr const char* type_text() {
  if constexpr (std::is_same_v<U, bool>)
    return "true or false";
  else if constexpr (std::is_same_v<U, int> || std::is_same_v<U, Index>)
    return "integer";
  else if constexpr (std::is_same_v<U, Real>)
    return "number";
  else if constexpr (std::is_same_v<U, std::string>)
    return "string";
  else if constexpr (std::is_same_v<U, Vec3>)
    return "dim numbers";
  else if constexpr (std::is_same_v<U, std::vector<Real>>)
    return "number or array of numbers";
  else if constexpr (std::is_same_v<U, std::vector<int>>)
    return "array of integers";
  else if constexpr (std::is_same_v<U, std::vector<std::string>>)
    return "array of strings";
  else if constexpr (std::is_same_v<U, std::vector<Vec3>>)
    return "array of points";
  else
    return type_text<typename U::value_type>();  // std::optional
}

/// Unknown keys of `table` are errors that offer the nearest of `names`.
void refuse_unknown_keys(const Input& table, const ReadContext& context, const std::vector<std::string>& names);

template <class T>
class ParameterTable {
 public:
  using Reader = std::function<void(T&, const Input&, const ReadContext&)>;
  using Writer = std::function<std::optional<Input>(const T&, int dim)>;

  template <class U>
  void required(std::string name, std::string unit, U T::*member, Constraint constraint, std::string help) {
    add(std::move(name), std::move(unit), member, std::move(constraint), std::move(help), true);
  }
  /// The default is the member's initialiser; an empty std::optional means "not given".
  template <class U>
  void optional(std::string name, std::string unit, U T::*member, Constraint constraint, std::string help) {
    add(std::move(name), std::move(unit), member, std::move(constraint), std::move(help), false);
  }
  /// One of a few words, each standing for a value of an enumeration.
  template <class E>
  void choice(std::string name, E T::*member, std::vector<std::pair<std::string, E>> words, std::string help, bool is_required = false) {
    ParameterDescription description{name, "1", "string", "", "", std::move(help), is_required};
    std::vector<std::string> names;
    for (const auto& [word, value] : words) {
      names.push_back(word);
      if (!is_required && value == T{}.*member) description.default_text = '"' + word + '"';
    }
    description.allowed = list_names(names);
    custom(
        std::move(description),
        [=](T& object, const Input& input, const ReadContext& context) {
          std::string given;
          read_value(input, context, name, any_number(), given);
          for (const auto& [word, value] : words) {
            if (word == given) {
              object.*member = value;
              return;
            }
          }
          fail_input(input, context,
                     fmt::format("{} = {} is unknown, allowed: {}{}", name, input.text(), list_names(names), did_you_mean(given, names)));
        },
        [=](const T& object, int) -> std::optional<Input> {
          for (const auto& [word, value] : words) {
            if (value == object.*member) return Input::string(word);
          }
          return std::nullopt;
        });
  }
  /// A value with its own reader and writer: a nested table, or a list of them.
  void custom(ParameterDescription description, Reader read, Writer write) {
    entries_.push_back({std::move(description), std::move(read), std::move(write)});
  }

  /// Reads all entries of `input` into `object`; `also_allowed` are keys that the caller reads itself.
  void read(const Input& input, const ReadContext& context, T& object, const std::vector<std::string>& also_allowed = {}) const {
    if (input.kind() != Input::Kind::table) fail_input(input, context, fmt::format("expected a table, got {}", input.text()));
    std::vector<std::string> names = also_allowed;
    for (const Entry& entry : entries_) names.push_back(entry.description.name);
    refuse_unknown_keys(input, context, names);
    for (const Entry& entry : entries_) {
      if (const Input* value = input.find(entry.description.name)) {
        entry.read(object, *value, context);
      } else if (entry.description.is_required) {
        const ParameterDescription& missing = entry.description;
        const std::string unit = missing.unit == "1" ? "" : fmt::format(" [{}]", missing.unit);
        fail_input(input, context, fmt::format("{} is missing ({}{}): {}", missing.name, missing.type, unit, missing.help));
      }
    }
  }

  /// The resolved values, defaults included, as they would stand in a case file.
  Input write(const T& object, int dim) const {
    Input table = Input::table();
    for (const Entry& entry : entries_) {
      if (std::optional<Input> value = entry.write(object, dim)) table.set(entry.description.name, std::move(*value));
    }
    return table;
  }

  std::vector<ParameterDescription> describe() const {
    std::vector<ParameterDescription> all;
    for (const Entry& entry : entries_) all.push_back(entry.description);
    return all;
  }

 private:
  struct Entry {
    ParameterDescription description;
    Reader read;
    Writer write;
  };

  template <class U>
  static std::optional<Input> write_member(const U& value, int dim) {
    return write_value(value, dim);
  }
  template <class U>
  static std::optional<Input> write_member(const std::optional<U>& value, int dim) {
    if (!value) return std::nullopt;
    return write_value(*value, dim);
  }

  template <class U>
  void add(std::string name, std::string unit, U T::*member, Constraint constraint, std::string help, bool is_required) {
    ParameterDescription description{name, std::move(unit), type_text<U>(), "", constraint.text, std::move(help), is_required};
    if (!is_required) {
      if (std::optional<Input> value = write_member(T{}.*member, 2)) description.default_text = value->text();
    }
    custom(
        std::move(description),
        [=](T& object, const Input& input, const ReadContext& context) { read_value(input, context, name, constraint, object.*member); },
        [=](const T& object, int dim) { return write_member(object.*member, dim); });
  }

  std::vector<Entry> entries_;
};

/// The parameter table of a type with `static void declare(ParameterTable<T>&)`.
template <class T>
const ParameterTable<T>& parameters_of() {
  static const ParameterTable<T> table = [] {
    ParameterTable<T> declared;
    T::declare(declared);
    return declared;
  }();
  return table;
}

/// Things chosen by the key `type`: regions, layouts, velocity fields, materials. A Derived has `static constexpr auto name`,
/// `static constexpr auto summary` and `declare`.
template <class Base>
class TypeRegistry {
 public:
  struct Entry {
    std::string name;
    std::string summary;
    std::vector<ParameterDescription> parameters;
    std::function<std::shared_ptr<Base>(const Input&, const ReadContext&)> read;
  };

  void add(Entry entry) { entries_.push_back(std::move(entry)); }

  template <class Derived>
  void add() {
    add({Derived::name, Derived::summary, parameters_of<Derived>().describe(), [](const Input& input, const ReadContext& context) {
           auto object = std::make_shared<Derived>();
           parameters_of<Derived>().read(input, context, *object, {"type"});
           object->check(input, context);
           return object;
         }});
  }

  /// Reads `{ type = "...", ... }`. `what` names the thing in messages, e.g. "region".
  std::shared_ptr<Base> read(const Input& input, const ReadContext& context, const std::string& what) const {
    if (std::shared_ptr<Base> object = input.as_object<Base>()) return object;
    if (input.kind() != Input::Kind::table) {
      fail_input(input, context, fmt::format("{} must be a table {{ type = ... }}, got {}", what, input.text()));
    }
    const Input* type = input.find("type");
    if (type == nullptr) fail_input(input, context, fmt::format("{} has no type, allowed: {}", what, list_names(names())));
    if (type->kind() != Input::Kind::string) {
      fail_input(*type, context, fmt::format("{} type must be a string, got {}", what, type->text()));
    }
    for (const Entry& entry : entries_) {
      if (entry.name == type->as_string()) {
        const ReadContext inside{context.dim, context.where.empty() ? what : context.where + ": " + what};
        return entry.read(input, inside);
      }
    }
    fail_input(*type, context,
               fmt::format("{} type = {} is unknown, allowed: {}{}", what, type->text(), list_names(names()),
                           did_you_mean(type->as_string(), names())));
  }

  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const Entry& entry : entries_) all.push_back(entry.name);
    return all;
  }
  const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::vector<Entry> entries_;
};

/// The table of a registered object, with its type: the counterpart of TypeRegistry::read.
template <class Derived>
Input write_typed(const Derived& object, int dim) {
  Input table = Input::table();
  table.set("type", Input::string(Derived::name));
  const Input values = parameters_of<Derived>().write(object, dim);
  for (const auto& [name, value] : values.entries()) table.set(name, value);
  return table;
}

}  // namespace matpoint
