// Wrong inputs as tables: a change of a valid case, and what the message has to say about it.
//
// A change replaces `from`, which occurs once in the case, by `to`; an empty `from` appends. The message must begin with the line of the
// change; where it belongs to another line of `to`, that line begins with @. A first part that begins with ^ is the whole beginning
// instead.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "case/case_file.hpp"
#include "run/simulation.hpp"
#include "support/temporary_folder.hpp"

namespace matpoint::test {

inline const std::string k_case = R"(title = "A block falls"
gravity = [0, -10]

[grid]
lower = [0, 0]
upper = [1, 1]
cells = [8, 8]
periodic = []
particles_outside = "error"

[time]
dt = 1e-4
end = 0.01

[solver]
stress_order = "musl"
flip = 1
damping = 0
mass_cutoff = 0

[output]
fields_at = [0.005]
formats = ["vtkhdf"]
precision = "single"

[[body]]
name = "block"
region = { type = "box", lower = [0.25, 0.5], upper = [0.75, 0.75] }
layout = { type = "per_cell", count = 4 }
velocity = { type = "uniform", value = [0, 0] }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }

[[boundary]]
side = "bottom"
kind = "slip"

[[probe]]
name = "tip"
body = "block"
particle = 0
)";

inline const std::string k_case_3d = R"(dim = 3

[grid]
upper = [1, 1, 1]
cells = [4, 4, 4]

[time]
end = 0.01

[[body]]
name = "block"
region = { type = "box", lower = [0.25, 0.25, 0.5], upper = [0.75, 0.75, 0.75] }
layout = { type = "per_cell", count = 8 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }
)";

struct WrongInput {
  std::string name;
  std::string from;
  std::string to;
  std::vector<std::string> parts;
};

/// What the program says about the case: reading and setting up, as `matpoint check` does.
inline std::string refusal(const std::string& text, const std::vector<std::string>& sets = {}) {
  return message_of<InputError>([&] {
    Input input = parse_toml(text, "case.toml");
    for (const std::string& set : sets) apply_set(input, set);
    Simulation simulation(Case::from_input(input, "case"));
  });
}

inline void expect_refused(const std::string& valid, const WrongInput& wrong) {
  const std::size_t at = wrong.from.empty() ? valid.size() : valid.find(wrong.from);
  ASSERT_NE(at, std::string::npos) << wrong.from << " is not in the case";
  std::string to = wrong.to;
  const std::size_t marker = to.starts_with("@") ? 0 : to.find("\n@") + 1;
  if (to.starts_with("@") || marker > 0) to.erase(marker, 1);
  const std::string text = valid.substr(0, at) + to + valid.substr(at + wrong.from.size());
  const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at + marker), '\n');

  const std::string message = refusal(text);
  std::vector<std::string> parts = wrong.parts;
  std::string beginning = fmt::format("case.toml:{}: ", line);
  if (parts.front().starts_with("^")) {
    beginning = parts.front().substr(1);
    parts.erase(parts.begin());
  }
  EXPECT_THAT(message, testing::StartsWith(beginning));
  for (const std::string& part : parts) EXPECT_THAT(message, testing::HasSubstr(part));
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

/// For the lists of tests.
inline void PrintTo(const WrongInput& wrong, std::ostream* out) { *out << wrong.name; }

inline std::string name_of(const testing::TestParamInfo<WrongInput>& info) { return info.param.name; }

}  // namespace matpoint::test
