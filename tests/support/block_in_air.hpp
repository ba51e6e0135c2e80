// A block that nothing holds: 0.6 x 0.3 (x 0.2) in a grid of 2 x 2 (x 1), cells of 0.1.
#pragma once

#include <fmt/format.h>

#include <string>

namespace matpoint::test {

/// `body`: more keys of the body, which come last but for what follows, further sections.
inline std::string block_in_air(int dim, const std::string& gravity, const std::string& end, const std::string& solver,
                                const std::string& body, const std::string& more) {
  const bool is_3d = dim == 3;
  return fmt::format(R"(
dim = {}
gravity = {}
[grid]
upper = {}
cell_size = 0.1
[time]
end = {}
[solver]
{}
[[body]]
name = "block"
region = {{ type = "box", lower = {}, upper = {} }}
layout = {{ type = "per_cell", count = {} }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }}
{}
{}
)",
                     dim, gravity, is_3d ? "[2, 2, 1]" : "[2, 2]", end, solver, is_3d ? "[0.7, 0.8, 0.4]" : "[0.7, 0.8]",
                     is_3d ? "[1.3, 1.1, 0.6]" : "[1.3, 1.1]", is_3d ? 8 : 4, body, more);
}

}  // namespace matpoint::test
