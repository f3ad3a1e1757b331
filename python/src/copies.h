// Copies of arrays in memory that is reused once no array refers to it.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstddef>
#include <memory>

namespace engram_python {

namespace nb = nanobind;

// Images of a whole batch fill many megabytes. Fresh memory of that size comes from the system
// page by page, which takes longer than to fill it. So a copy's memory goes back to where it came
// from when the array that was handed out has died, and with it every view and every tensor that
// was made of it: they hold the array, and it holds its memory. What is held is never written to.
class Copies {
 public:
  using Array = nb::ndarray<nb::ro, nb::c_contig, nb::device::cpu>;

  Copies();

  // A new array; its memory begins at a multiple of 64, because jax takes over no other.
  nb::object copy(const Array& array);
  // Bytes that lie ready for copies to come.
  std::size_t spare() const;

 private:
  class Store;
  std::shared_ptr<Store> store_;  // shared by the arrays: they may live longer
};

}  // namespace engram_python
