// How the commands write numbers, words and warnings.
#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <system_error>

#include "commands.hpp"

namespace matpoint {

void print_warning(const std::string& text) {
  std::fflush(stdout);  // in a terminal the two streams are one text
  std::fputs(fmt::format("warning: {}\n", text).c_str(), stderr);
}

void settle_standard_output() {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return;
  const std::string reason = std::generic_category().message(errno);
  // What is still in the buffer goes nowhere.
  if (std::freopen("/dev/null", "w", stdout) == nullptr) return;
  print_warning(fmt::format("cannot write to standard output: {}; the results are complete", reason));
}

std::string shell_word(const std::string& word) {
  const auto is_plain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || std::string_view("_-+./:=,@%").find(c) != std::string_view::npos;
  };
  if (!word.empty() && std::all_of(word.begin(), word.end(), is_plain)) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string duration_text(double seconds) {
  if (!std::isfinite(seconds)) return "unknown";
  if (seconds < 99.95) return fmt::format("{:.{}f} s", seconds, seconds < 9.995 ? 2 : 1);
  const auto whole = static_cast<long long>(std::llround(std::min(seconds, 1e15)));
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  if (whole < 48 * 3600) return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
  return fmt::format("{} days {} h", whole / 86400, whole / 3600 % 24);
}

std::string count_text(double count) {
  if (!std::isfinite(count)) return "unknown";
  double value = count;
  for (const char* unit : {"", " k", " M", " G", " T", " P"}) {
    if (std::abs(value) < 999.5) return fmt::format("{:.{}f}{}", value, *unit == 0 || value >= 99.95 ? 0 : value >= 9.995 ? 1 : 2, unit);
    value /= 1000;
  }
  return fmt::format("{:.3g}", count);
}

}  // namespace matpoint
