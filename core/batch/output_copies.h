// Copies of a batch's outputs in arrays outside of it: those that several batches share, or a
// user's own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/task/task.h"

namespace engram {

// A part of every row of one array, and its place in the rows of another.
struct RowCopy {
  const std::byte* from = nullptr;
  std::byte* to = nullptr;
  std::size_t from_row = 0;  // bytes from row to row
  std::size_t to_row = 0;
  std::size_t bytes = 0;
  bool int_to_float = false;  // int32 becomes float32
};

class OutputCopies {
 public:
  // Parts that adjoin the one before, on both sides, become one with it.
  void add(const RowCopy& copy) { add_to(rows_, copy); }
  // A copy for environments whose episodes end in this step.
  void add_final(const RowCopy& copy) { add_to(final_rows_, copy); }

  // final_mask: of all environments.
  void copy(Range envs, const std::uint8_t* final_mask) const noexcept;

 private:
  static void add_to(std::vector<RowCopy>& rows, const RowCopy& copy);

  std::vector<RowCopy> rows_;
  std::vector<RowCopy> final_rows_;
};

}  // namespace engram
