// Policies in Python, evaluated by the library.
#pragma once

#include <nanobind/nanobind.h>

namespace engram_python {

void bind_evaluate(nanobind::module_& module);

}  // namespace engram_python
