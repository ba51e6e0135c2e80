// Layouts with layers of ever finer particles at the surface, so that the surface is sharp where bodies touch.
#pragma once

#include "geometry/layout.hpp"

namespace matpoint {

/// Adds layered_disk and layered_beam.
void add_layered_layouts(TypeRegistry<Layout>& registry);

}  // namespace matpoint
