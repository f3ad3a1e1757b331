// The outputs of a batch as arrays over its environments: columns, observations and images alike.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/batch/batch_data.h"

namespace engram {

struct OutputArray {
  Field field;                      // its width: elements of one environment
  std::vector<std::int64_t> shape;  // num_envs first; without a second one where the width is 1
  std::byte* data = nullptr;

  std::size_t row_bytes() const {
    return static_cast<std::size_t>(field.width) * size_of(field.dtype);
  }
};

// An array without data. Members are set one by one: GCC 12 destroys members of nested braces twice
// where memory runs out in between.
OutputArray make_output_array(const char* name, int width, DType dtype, const char* unit,
                              const char* description, int num_envs);

// Outputs in the order of users' lists: columns, final_mask, images.
std::vector<OutputArray> output_arrays(const BatchData& data);
// Those that final outputs have; empty unless the batch keeps any.
std::vector<OutputArray> final_output_arrays(const BatchData& data);

// The array of that name; null if there is none.
const OutputArray* find_array(const std::vector<OutputArray>& arrays, std::string_view name);

}  // namespace engram
