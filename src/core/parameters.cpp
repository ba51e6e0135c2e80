#include "core/parameters.hpp"

#include <limits>

namespace matpoint {
namespace {

Constraint make(std::string text, std::function<bool(Real)> holds) { return {std::move(text), std::move(holds)}; }

void check(const Input& input, const ReadContext& context, const std::string& name, const Constraint& constraint, Real value) {
  if (!std::isfinite(value)) fail_input(input, context, fmt::format("{} = {} is not a finite number", name, input.text()));
  if (constraint.holds && !constraint.holds(value)) {
    fail_input(input, context, fmt::format("{} = {} is not allowed, it must be {}", name, input.text(), constraint.text));
  }
}

const std::vector<Input>& items_of(const Input& input, const ReadContext& context, const std::string& name, const std::string& expected) {
  if (input.kind() != Input::Kind::array) {
    fail_input(input, context, fmt::format("{} must be {}, got {} ({})", name, expected, input.text(), input.kind_text()));
  }
  return input.items();
}

}  // namespace

Constraint any_number() { return make("", nullptr); }
Constraint positive() {
  return make("> 0", [](Real x) { return x > 0; });
}
Constraint non_negative() {
  return make(">= 0", [](Real x) { return x >= 0; });
}
Constraint at_least(Real lower) {
  return make(fmt::format(">= {}", lower), [=](Real x) { return x >= lower; });
}
Constraint between(Real lower, Real upper) {
  return make(fmt::format("in the open interval ({}, {})", lower, upper), [=](Real x) { return x > lower && x < upper; });
}
Constraint between_closed(Real lower, Real upper) {
  return make(fmt::format("in the interval [{}, {}]", lower, upper), [=](Real x) { return x >= lower && x <= upper; });
}

void fail_input(const Input& input, const ReadContext& context, const std::string& text) {
  std::string message;
  if (!input.place().empty()) message += input.place() + ": ";
  if (!context.where.empty()) message += context.where + ": ";
  message += text;
  throw InputError(printable(message, message.size()));
}

void refuse_unknown_keys(const Input& table, const ReadContext& context, const std::vector<std::string>& names) {
  for (const auto& [key, value] : table.entries()) {
    bool is_known = false;
    for (const std::string& name : names) is_known = is_known || name == key;
    if (is_known) continue;
    const std::string shown = printable(key, 60);
    const std::string hint = did_you_mean(key, names);
    fail_input(value, context, fmt::format("unknown key \"{}\"{}", shown, hint.empty() ? "; known keys: " + list_names(names) : hint));
  }
}

void read_value(const Input& input, const ReadContext& context, const std::string& name, const Constraint&, bool& value) {
  if (input.kind() != Input::Kind::boolean) {
    fail_input(input, context, fmt::format("{} must be true or false, got {} ({})", name, input.text(), input.kind_text()));
  }
  value = input.as_boolean();
}

void read_value(const Input& input, const ReadContext& context, const std::string& name, const Constraint& constraint, Index& value) {
  // 1e6 is a natural way to write a count, so a real that is whole is an integer.
  const bool is_whole = input.is_number() && std::abs(input.as_real()) < 9e15 && input.as_real() == std::floor(input.as_real());
  if (!is_whole) fail_input(input, context, fmt::format("{} must be an integer, got {} ({})", name, input.text(), input.kind_text()));
  check(input, context, name, constraint, input.as_real());
  value = static_cast<Index>(input.as_real());
}

void read_value(const Input& input, const ReadContext& context, const std::string& name, const Constraint& constraint, int& value) {
  Index wide = 0;
  read_value(input, context, name, constraint, wide);
  if (wide > std::numeric_limits<int>::max() || wide < std::numeric_limits<int>::min()) {
    fail_input(input, context, fmt::format("{} = {} is too large", name, input.text()));
  }
  value = static_cast<int>(wide);
}

void read_value(const Input& input, const ReadContext& context, const std::string& name, const Constraint& constraint, Real& value) {
  if (!input.is_number()) {
    fail_input(input, context, fmt::format("{} must be a number, got {} ({})", name, input.text(), input.kind_text()));
  }
  check(input, context, name, constraint, input.as_real());
  value = input.as_real();
}

void read_value(const Input& input, const ReadContext& context, const std::string& name, const Constraint&, std::string& value) {
  if (input.kind() != Input::Kind::string) {
    fail_input(input, context, fmt::format("{} must be a string, got {} ({})", name, input.text(), input.kind_text()));
  }
  value = input.as_string();
}

void read_value(const Input& input, const ReadContext& context, const std::string& name, const Constraint& constraint, Vec3& value) {
  const auto& items = items_of(input, context, name, fmt::format("an array of {} numbers", context.dim));
  if (static_cast<int>(items.size()) != context.dim) {
    fail_input(input, context,
               fmt::format("{} = {} has {} numbers; the case has dim = {}, so it must have {}", name, input.text(), items.size(),
                           context.dim, context.dim));
  }
  value = {0, 0, 0};
  for (std::size_t d = 0; d < items.size(); ++d) read_value(items[d], context, fmt::format("{}[{}]", name, d), constraint, value[d]);
}

void read_value(const Input& input, const ReadContext& context, const std::string& name, const Constraint& constraint,
                std::vector<Real>& value) {
  value.clear();
  if (input.is_number()) {
    value.resize(1);
    read_value(input, context, name, constraint, value[0]);
    return;
  }
  const auto& items = items_of(input, context, name, "a number or an array of numbers");
  value.resize(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) read_value(items[i], context, fmt::format("{}[{}]", name, i), constraint, value[i]);
}

void read_value(const Input& input, const ReadContext& context, const std::string& name, const Constraint& constraint,
                std::vector<int>& value) {
  const auto& items = items_of(input, context, name, "an array of integers");
  value.assign(items.size(), 0);
  for (std::size_t i = 0; i < items.size(); ++i) read_value(items[i], context, fmt::format("{}[{}]", name, i), constraint, value[i]);
}

void read_value(const Input& input, const ReadContext& context, const std::string& name, const Constraint& constraint,
                std::vector<std::string>& value) {
  const auto& items = items_of(input, context, name, "an array of strings");
  value.assign(items.size(), "");
  for (std::size_t i = 0; i < items.size(); ++i) read_value(items[i], context, fmt::format("{}[{}]", name, i), constraint, value[i]);
}

void read_value(const Input& input, const ReadContext& context, const std::string& name, const Constraint& constraint,
                std::vector<Vec3>& value) {
  const auto& items = items_of(input, context, name, "an array of points");
  value.assign(items.size(), Vec3{});
  for (std::size_t i = 0; i < items.size(); ++i) read_value(items[i], context, fmt::format("{}[{}]", name, i), constraint, value[i]);
}

Input write_value(bool value, int) { return Input::boolean(value); }
Input write_value(int value, int) { return Input::integer(value); }
Input write_value(Index value, int) { return Input::integer(value); }
Input write_value(Real value, int) { return Input::real(value); }
Input write_value(const std::string& value, int) { return Input::string(value); }

Input write_value(const Vec3& value, int dim) {
  Input array = Input::array();
  for (int d = 0; d < dim; ++d) array.items().push_back(Input::real(value[static_cast<std::size_t>(d)]));
  return array;
}

namespace {
template <class U>
Input write_items(const std::vector<U>& values, int dim) {
  Input array = Input::array();
  for (const U& value : values) array.items().push_back(write_value(value, dim));
  return array;
}
}  // namespace

Input write_value(const std::vector<Real>& value, int dim) { return write_items(value, dim); }
Input write_value(const std::vector<int>& value, int dim) { return write_items(value, dim); }
Input write_value(const std::vector<std::string>& value, int dim) { return write_items(value, dim); }
Input write_value(const std::vector<Vec3>& value, int dim) { return write_items(value, dim); }

}  // namespace matpoint
