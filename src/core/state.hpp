// What an object keeps from one step to the next, declared once.
//
//     void declare_state(State& state) {
//       state.add("time", time_);
//       state.part("ledger", ledger_);       // which declares its own
//       state.rows("holds", holds_);         // a list of objects, a column for each thing that they declare
//     }
//
// The same declaration saves into a table of named arrays and loads from one; files, copies and checks of a run's state follow from it.
// Not declared is what the case gives (a loading object has been built from the same case), and what a step makes anew before it reads it.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "core/error.hpp"
#include "core/types.hpp"

namespace matpoint {

/// Numbers as they are kept in memory: real ones in their own precision, whole ones and yes or no as integers; or a text.
using StateArray = std::variant<std::vector<double>, std::vector<float>, std::vector<Index>, std::string>;
/// By path: "solver/body/ball/velocity".
using StateTable = std::map<std::string, StateArray>;

namespace state_detail {

template <class T>
constexpr bool is_number = std::is_arithmetic_v<T> || std::is_enum_v<T>;

template <class T>
struct IsFixed : std::bool_constant<is_number<T>> {};
template <class T, std::size_t n>
struct IsFixed<std::array<T, n>> : IsFixed<T> {};
template <class T, std::size_t n>
struct IsFixed<T[n]> : IsFixed<T> {};

/// How a number is kept.
template <class T>
struct Kept {
  using type = Index;
};
template <>
struct Kept<double> {
  using type = double;
};
template <>
struct Kept<float> {
  using type = float;
};
template <class T, std::size_t n>
struct Kept<std::array<T, n>> : Kept<T> {};
template <class T, std::size_t n>
struct Kept<T[n]> : Kept<T> {};

template <class T, class F>
void for_each_number(T& value, F&& f) {
  if constexpr (is_number<T>)
    f(value);
  else
    for (auto& item : value) for_each_number(item, f);
}

template <class T>
constexpr std::size_t width() {
  if constexpr (is_number<T>)
    return 1;
  else
    return sizeof(T) / sizeof(std::declval<T&>()[0]) * width<std::remove_reference_t<decltype(std::declval<T&>()[0])>>();
}

}  // namespace state_detail

class State {
 public:
  /// Saves into the table. `spare`: an earlier table that is of no use any more and lends its memory; null: none.
  static State saving(StateTable& table, StateTable* spare = nullptr) {
    State state{&table, nullptr};
    state.spare_ = spare;
    return state;
  }
  /// Loads from it.
  static State loading(const StateTable& table, bool is_changed = false) { return {nullptr, &table, is_changed}; }

  bool is_loading() const { return from_ != nullptr; }
  /// Whether the state is that of another case, with other loads or sides: what follows from these is made anew.
  bool is_changed() const { return is_changed_; }

  /// A number, an array of numbers of fixed length, or a list of either; a text. Loading throws InputError where the table has nothing of
  /// the name, or not as many numbers.
  template <class T>
  void add(const std::string& name, T& value) {
    if constexpr (std::is_same_v<T, std::string>)
      add_text(name, value);
    else if constexpr (state_detail::IsFixed<T>::value)
      add_fixed(name, value);
    else
      add_list(name, value);
  }

  /// The same for long lists that are of no use to the caller afterwards: saving does not copy them.
  template <class T>
  void take(const std::string& name, std::vector<T>& values) {
    if (is_loading()) {
      values = find_numbers<T>(name);
    } else if (!to_->try_emplace(path_ + name, std::move(values)).second) {
      fail(name, "is declared twice");
    }
  }

  /// Memory for what take() will get: new memory costs more than filling it.
  template <class T>
  std::vector<T> spare_list(const std::string& name) {
    if (spare_ == nullptr) return {};
    const auto found = spare_->find(path_ + name);
    auto* const values = found == spare_->end() ? nullptr : std::get_if<std::vector<T>>(&found->second);
    return values == nullptr ? std::vector<T>{} : std::move(*values);
  }

  /// Something that is there or not.
  template <class T>
  void add(const std::string& name, std::optional<T>& value) {
    std::vector<T> all;
    if (value) all.push_back(*value);
    add(name, all);
    if (!is_loading()) return;
    value.reset();
    if (!all.empty()) value = all.front();
  }

  void add(const std::string& name, std::set<Index>& value) {
    std::vector<Index> all(value.begin(), value.end());
    add(name, all);
    if (is_loading()) value = {all.begin(), all.end()};
  }

  void add(const std::string& name, std::vector<bool>& value) {
    std::vector<Index> all(value.begin(), value.end());
    add(name, all);
    if (is_loading()) value.assign(all.begin(), all.end());
  }

  /// What `f` declares, under a name.
  template <class F>
  void in(const std::string& name, F&& f) {
    const std::size_t length = path_.size();
    path_ += name + "/";
    f();
    path_.resize(length);
  }
  template <class T>
  void part(const std::string& name, T& object) {
    in(name, [&] { object.declare_state(*this); });
  }
  /// Objects that are there already.
  template <class T>
  void parts(const std::string& name, T& objects) {
    std::size_t k = 0;
    in(name, [&] {
      for (auto& object : objects) part(std::to_string(k++), object);
    });
  }

  /// A list of objects that declare things of fixed length: a column for each of these.
  template <class T>
  void rows(const std::string& name, std::vector<T>& objects) {
    in(name, [&] {
      auto count = static_cast<Index>(objects.size());
      add("count", count);
      if (is_loading()) {
        if (count < 0) fail("count", "is negative");
        objects.assign(static_cast<std::size_t>(count), T{});
      }
      rows_ = count;
      row_ = 0;
      for (T& object : objects) {
        object.declare_state(*this);
        ++row_;
      }
      rows_ = -1;
    });
  }
  /// The same by id.
  template <class T>
  void rows(const std::string& name, std::map<Index, T>& objects) {
    struct Row {
      Index id = 0;
      T object{};
      void declare_state(State& state) {
        state.add("id", id);
        object.declare_state(state);
      }
    };
    std::vector<Row> all;
    for (const auto& [id, object] : objects) all.push_back({id, object});
    rows(name, all);
    if (!is_loading()) return;
    objects.clear();
    for (Row& row : all) objects.emplace(row.id, std::move(row.object));
  }
  void rows(const std::string& name, std::map<Index, Real>& numbers);

  /// Of the present place, for messages.
  [[noreturn]] void fail(const std::string& name, const std::string& reason) const {
    throw InputError("the state does not fit: {}{} {}", path_, name, reason);
  }
  /// What the table has below a path and nothing has asked for; empty if all was loaded.
  std::vector<std::string> left_over(const std::string& below) const;

 private:
  State(StateTable* to, const StateTable* from, bool is_changed = false) : to_(to), from_(from), is_changed_(is_changed) {}

  const StateArray& find(const std::string& name);
  void add_text(const std::string& name, std::string& value);

  template <class Element>
  const std::vector<Element>& find_numbers(const std::string& name) {
    const auto* const numbers = std::get_if<std::vector<Element>>(&find(name));
    if (numbers == nullptr) fail(name, "is of another kind of number (solver.precision?)");
    return *numbers;
  }

  template <class T>
  void add_fixed(const std::string& name, T& value) {
    using Element = typename state_detail::Kept<T>::type;
    constexpr std::size_t width = state_detail::width<T>();
    if (is_loading()) {
      const std::vector<Element>& all = find_numbers<Element>(name);
      const auto rows = static_cast<std::size_t>(rows_ < 0 ? 1 : rows_);
      if (all.size() != rows * width) fail(name, fmt::format("has {} numbers, not {}", all.size(), rows * width));
      const Element* next = all.data() + (rows_ < 0 ? 0 : static_cast<std::size_t>(row_) * width);
      state_detail::for_each_number(value, [&](auto& number) { number = static_cast<std::remove_reference_t<decltype(number)>>(*next++); });
      return;
    }
    if (rows_ < 0 && to_->count(path_ + name) > 0) fail(name, "is declared twice");
    auto& all = std::get<std::vector<Element>>(to_->try_emplace(path_ + name, std::vector<Element>{}).first->second);
    if (all.empty() && rows_ > 0) all.reserve(static_cast<std::size_t>(rows_) * width);
    state_detail::for_each_number(value, [&](auto& number) { all.push_back(static_cast<Element>(number)); });
  }

  template <class T>
  void add_list(const std::string& name, std::vector<T>& values) {
    static_assert(state_detail::IsFixed<T>::value, "lists of objects are declared with rows() or parts()");
    using Element = typename state_detail::Kept<T>::type;
    constexpr std::size_t width = state_detail::width<T>();
    if (is_loading()) {
      const std::vector<Element>& all = find_numbers<Element>(name);
      if (all.size() % width != 0) fail(name, fmt::format("has {} numbers, which is no multiple of {}", all.size(), width));
      values.resize(all.size() / width);
      const Element* next = all.data();
      for (T& value : values) {
        state_detail::for_each_number(value,
                                      [&](auto& number) { number = static_cast<std::remove_reference_t<decltype(number)>>(*next++); });
      }
      return;
    }
    std::vector<Element> all(values.size() * width);
    Element* next = all.data();
    for (T& value : values) state_detail::for_each_number(value, [&](auto& number) { *next++ = static_cast<Element>(number); });
    if (!to_->try_emplace(path_ + name, std::move(all)).second) fail(name, "is declared twice");
  }

  StateTable* to_;
  const StateTable* from_;
  StateTable* spare_ = nullptr;
  bool is_changed_;
  std::set<std::string> asked_for_;
  std::string path_;
  Index rows_ = -1;  ///< Of the list that is being declared; -1: none.
  Index row_ = 0;
};

}  // namespace matpoint
