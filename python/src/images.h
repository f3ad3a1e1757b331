// Conversion and statistics of images, for data sets.
#pragma once

#include <nanobind/nanobind.h>

namespace engram_python {

namespace nb = nanobind;

void bind_images(nb::module_& module);

}  // namespace engram_python
