// Python functions where the core takes regions, layouts, laws, boundary values and body forces.
#pragma once

#include <nanobind/nanobind.h>

namespace matpoint::python {

void bind_functions(nanobind::module_& m);

}  // namespace matpoint::python
