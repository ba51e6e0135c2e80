#include "core/state.hpp"

namespace matpoint {

const StateArray& State::find(const std::string& name) {
  const auto found = from_->find(path_ + name);
  if (found == from_->end()) fail(name, "is missing");
  if (row_ == 0 || rows_ < 0) asked_for_.insert(found->first);
  return found->second;
}

void State::add_text(const std::string& name, std::string& value) {
  if (is_loading()) {
    const auto* const text = std::get_if<std::string>(&find(name));
    if (text == nullptr) fail(name, "is no text");
    value = *text;
  } else if (!to_->try_emplace(path_ + name, value).second) {
    fail(name, "is declared twice");
  }
}

void State::rows(const std::string& name, std::map<Index, Real>& numbers) {
  std::vector<Index> ids;
  std::vector<Real> values;
  for (const auto& [id, value] : numbers) {
    ids.push_back(id);
    values.push_back(value);
  }
  in(name, [&] {
    add("id", ids);
    add("value", values);
    if (ids.size() != values.size()) fail("value", "has not one number for each id");
  });
  if (!is_loading()) return;
  numbers.clear();
  for (std::size_t k = 0; k < ids.size(); ++k) numbers[ids[k]] = values[k];
}

std::vector<std::string> State::left_over(const std::string& below) const {
  std::vector<std::string> names;
  for (const auto& [name, array] : *from_) {
    if (name.starts_with(below) && asked_for_.count(name) == 0) names.push_back(name);
  }
  return names;
}

}  // namespace matpoint
