// Python functions where the core takes regions, layouts, laws, boundary values and body forces.
#pragma once

#include <nanobind/nanobind.h>

namespace matpoint::python {

void bind_functions(nanobind::module_& m);

/// Whether Ctrl-C met a function of a case in the middle of a step since the last call. The function was called once more, and the run
/// ends after the step.
bool take_interrupt();

}  // namespace matpoint::python
