// One value of a case as the user gave it, with the place it came from. Case files, --set and Python all become this tree, so every
// check and every message exists once.
#pragma once

#include <any>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/types.hpp"

namespace matpoint {

class Input {
 public:
  enum class Kind { boolean, integer, real, string, array, table, object };

  static Input boolean(bool value);
  static Input integer(Index value);
  static Input real(Real value);
  static Input string(std::string value);
  static Input array(std::vector<Input> items = {});
  static Input table();
  /// Something that no file can hold, e.g. a region whose points a function chooses; `text` names it in messages.
  template <class T>
  static Input object(std::shared_ptr<T> value, std::string text) {
    Input input;
    input.kind_ = Kind::object;
    input.object_ = std::move(value);
    input.string_ = std::move(text);
    return input;
  }

  Kind kind() const { return kind_; }
  bool is_number() const { return kind_ == Kind::integer || kind_ == Kind::real; }
  /// "a table", "an integer", ... for messages.
  std::string kind_text() const;
  /// The value as it would stand in a case file, shortened for messages.
  std::string text() const;

  bool as_boolean() const { return boolean_; }
  Index as_integer() const { return integer_; }
  /// The number, whether it was written as an integer or with a point.
  Real as_real() const { return kind_ == Kind::integer ? static_cast<Real>(integer_) : real_; }
  const std::string& as_string() const { return string_; }
  /// The object, if it was given as a T; else null.
  template <class T>
  std::shared_ptr<T> as_object() const {
    const auto* pointer = std::any_cast<std::shared_ptr<T>>(&object_);
    return pointer != nullptr ? *pointer : nullptr;
  }
  const std::vector<Input>& items() const { return items_; }
  std::vector<Input>& items() { return items_; }
  const std::vector<std::pair<std::string, Input>>& entries() const { return entries_; }
  std::vector<std::pair<std::string, Input>>& entries() { return entries_; }

  const Input* find(const std::string& key) const;
  Input* find(const std::string& key);
  /// Adds or replaces an entry of a table.
  Input& set(const std::string& key, Input value);

  /// Where it was given: "case.toml:14", "--set solver.cfl", or empty.
  const std::string& place() const { return place_; }
  Input& with_place(std::string place) {
    place_ = std::move(place);
    return *this;
  }

 private:
  Kind kind_ = Kind::table;
  bool boolean_ = false;
  Index integer_ = 0;
  Real real_ = 0;
  std::string string_;
  std::any object_;
  std::vector<Input> items_;
  std::vector<std::pair<std::string, Input>> entries_;
  std::string place_;
};

}  // namespace matpoint
