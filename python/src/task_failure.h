// The last exception that came out of the code of a task in Python.
#pragma once

#include <nanobind/nanobind.h>

namespace engram_python {

// Both need a thread of Python.
void keep_task_failure(nanobind::python_error&& error);
// Raises it, unless that has been done already.
void raise_task_failure();

}  // namespace engram_python
