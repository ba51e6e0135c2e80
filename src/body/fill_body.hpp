// The particles of a body as its description says.
#pragma once

#include "case/body_spec.hpp"
#include "geometry/layout.hpp"

namespace matpoint {

/// The particles of a body. Throws InputError for an empty body and for particles outside of the grid.
Seeds fill_body(const BodySpec& body, const SeedingGrid& grid);

}  // namespace matpoint
