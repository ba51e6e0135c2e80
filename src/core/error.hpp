// The three ways in which a run can end badly, each with its own exit code (docs/case_file.md lists them).
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace matpoint {

/// Something in the input is wrong: exit code 2. The text names the place, the value and what is allowed.
class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& text) : std::runtime_error(text) {}
  template <class... Args>
  explicit InputError(fmt::format_string<Args...> format, Args&&... args)
      : std::runtime_error(fmt::format(format, std::forward<Args>(args)...)) {}
};

/// A valid case failed while it ran (state not finite, particle lost, disk full): exit code 3.
class SolverError : public std::runtime_error {
 public:
  explicit SolverError(const std::string& text) : std::runtime_error(text) {}
  template <class... Args>
  explicit SolverError(fmt::format_string<Args...> format, Args&&... args)
      : std::runtime_error(fmt::format(format, std::forward<Args>(args)...)) {}
};

/// The same, of one particle of a body.
class ParticleError : public SolverError {
 public:
  ParticleError(const std::string& text, std::size_t body_, long long id_) : SolverError(text), body(body_), id(id_) {}
  std::size_t body;
  long long id;
};

/// The candidate with the smallest edit distance to `name`; empty if none is near enough to be meant.
std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates);

/// `; did you mean "x"?` or an empty string.
std::string did_you_mean(std::string_view name, const std::vector<std::string>& candidates);

/// Text from outside as messages show it: one line without control characters, cut after `longest` bytes, never within a character.
std::string printable(std::string_view text, std::size_t longest = 200);

/// "a", "b" or "c".
std::string list_names(const std::vector<std::string>& names);

}  // namespace matpoint

#ifdef NDEBUG
#define MPM_ASSERT(condition) ((void)0)
#else
#include <cassert>
#define MPM_ASSERT(condition) assert(condition)
#endif
