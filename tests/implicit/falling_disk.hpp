// A case that tests of the implicit solver share.
#pragma once

namespace matpoint::test {

/// A disk that falls on the bottom of its box and turns.
constexpr const char* k_falling_disk = R"(
gravity = [0, -9.81]
[grid]
lower = [0, 0]
upper = [2, 2]
cells = [10, 10]
[time]
end = 0.3
dt = 0.005
[solver]
type = "implicit"
[[body]]
name = "disk"
region = { type = "disk", center = [1, 0.75], radius = 0.5 }
layout = { type = "per_cell", count = 25 }
velocity = { type = "rotating", center = [1, 0.75], angular_velocity = 3, value = [0.4, -2] }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }
[[boundary]]
side = "bottom"
kind = "fixed"
)";

}  // namespace matpoint::test
