// Fields of the C API's structs as properties of a Python object.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <string>
#include <type_traits>
#include <utility>

#include "batch.h"

namespace engram_python {

// A function that adds a property by name and pointer to member, for a class that has the struct as
// `plain`, and `texts`, a deque, for the texts that it points to.
template <class Owner>
auto field_binder(nb::class_<Owner>& owner) {
  return [&owner](const char* name, auto field) {
    using Value = std::remove_reference_t<decltype(std::declval<Owner&>().plain.*field)>;
    const auto get = [field](const Owner& self) { return self.plain.*field; };
    if constexpr (std::is_same_v<Value, const char*>) {
      owner.def_prop_rw(name, get, [field](Owner& self, const std::string& value) {
        self.plain.*field = c_text(self.texts.emplace_back(value));
      });
    } else {
      owner.def_prop_rw(name, get,
                        [field](Owner& self, Value value) { self.plain.*field = value; });
    }
  };
}

}  // namespace engram_python
