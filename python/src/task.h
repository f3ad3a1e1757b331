// Tasks that are written in Python.
#pragma once

#include <nanobind/nanobind.h>

namespace engram_python {

namespace nb = nanobind;

void bind_tasks(nb::module_& module);
void bind_task_functions(nb::module_& module);

}  // namespace engram_python
