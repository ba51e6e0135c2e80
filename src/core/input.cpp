#include "core/input.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/error.hpp"

namespace matpoint {

Input Input::boolean(bool value) {
  Input input;
  input.kind_ = Kind::boolean;
  input.boolean_ = value;
  return input;
}

Input Input::integer(Index value) {
  Input input;
  input.kind_ = Kind::integer;
  input.integer_ = value;
  return input;
}

Input Input::real(Real value) {
  Input input;
  input.kind_ = Kind::real;
  input.real_ = value;
  return input;
}

Input Input::string(std::string value) {
  Input input;
  input.kind_ = Kind::string;
  input.string_ = std::move(value);
  return input;
}

Input Input::array(std::vector<Input> items) {
  Input input;
  input.kind_ = Kind::array;
  input.items_ = std::move(items);
  return input;
}

Input Input::table() { return Input{}; }

std::string Input::kind_text() const {
  switch (kind_) {
    case Kind::boolean: return "true or false";
    case Kind::integer: return "an integer";
    case Kind::real: return "a number";
    case Kind::string: return "a string";
    case Kind::array: return "an array";
    case Kind::table: return "a table";
    case Kind::object: return "an object";
  }
  return "";
}

std::string Input::text() const {
  constexpr std::size_t k_longest = 60;
  std::string text;
  switch (kind_) {
    case Kind::boolean: text = boolean_ ? "true" : "false"; break;
    case Kind::integer: text = fmt::format("{}", integer_); break;
    case Kind::real: text = std::isnan(real_) ? "nan" : fmt::format("{}", real_); break;
    case Kind::string: text = '"' + string_ + '"'; break;
    case Kind::array:
      text = "[";
      for (std::size_t i = 0; i < items_.size() && text.size() <= k_longest; ++i) text += (i > 0 ? ", " : "") + items_[i].text();
      text += "]";
      break;
    case Kind::table: text = "{...}"; break;
    case Kind::object: text = string_; break;
  }
  return printable(text, k_longest);
}

const Input* Input::find(const std::string& key) const {
  for (const auto& [name, value] : entries_) {
    if (name == key) return &value;
  }
  return nullptr;
}

Input* Input::find(const std::string& key) { return const_cast<Input*>(static_cast<const Input*>(this)->find(key)); }

Input& Input::set(const std::string& key, Input value) {
  if (Input* existing = find(key)) {
    *existing = std::move(value);
    return *existing;
  }
  entries_.emplace_back(key, std::move(value));
  return entries_.back().second;
}

}  // namespace matpoint
