// A simulation with what Python needs beside it: the history in memory, callbacks, signals and a results folder.
#pragma once

#include <nanobind/nanobind.h>

namespace matpoint::python {

void bind_simulation(nanobind::module_& m);

}  // namespace matpoint::python
