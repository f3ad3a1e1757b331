// One environment's part of what a batch shows.
#pragma once

#include <cstddef>
#include <span>

#include "core/batch/batch.h"

namespace engram {

// Its row of an array that has one for every environment.
template <class T>
std::span<const T> row_of(std::span<const T> all, const Batch& batch, int index) {
  const std::size_t width = all.size() / static_cast<std::size_t>(batch.num_envs());
  return all.subspan(static_cast<std::size_t>(index) * width, width);
}

// Its value of an output of width 1; T is the output's type.
template <class T>
T value_of(const ColumnView& output, int index) {
  return *reinterpret_cast<const T*>(output.row(index));
}

}  // namespace engram
