// Tasks that are written in Python.
#pragma once

#include <nanobind/nanobind.h>

namespace engram_python {

namespace nb = nanobind;

// Raises the last exception that came out of a task's code, unless that has been done already.
// Needs the GIL.
void raise_task_failure();

void bind_tasks(nb::module_& module);
void bind_task_functions(nb::module_& module);

}  // namespace engram_python
