#include "core/batch/output_copies.h"

#include <cstring>

#include "core/base/index.h"

namespace engram {
namespace {

void copy_rows(const RowCopy& copy, Range envs) noexcept {
  const auto first = at(envs.begin);
  const auto count = at(envs.end - envs.begin);
  const std::byte* from = copy.from + first * copy.from_row;
  std::byte* to = copy.to + first * copy.to_row;
  if (copy.int_to_float) {
    for (std::size_t row = 0; row < count; ++row) {
      for (std::size_t byte = 0; byte < copy.bytes; byte += sizeof(float)) {
        std::int32_t whole = 0;
        std::memcpy(&whole, from + row * copy.from_row + byte, sizeof whole);
        const auto real = static_cast<float>(whole);
        std::memcpy(to + row * copy.to_row + byte, &real, sizeof real);
      }
    }
  } else if (copy.from_row == copy.bytes && copy.to_row == copy.bytes) {
    std::memcpy(to, from, count * copy.bytes);
  } else {
    for (std::size_t row = 0; row < count; ++row) {
      std::memcpy(to + row * copy.to_row, from + row * copy.from_row, copy.bytes);
    }
  }
}

}  // namespace

void OutputCopies::add_to(std::vector<RowCopy>& rows, const RowCopy& copy) {
  if (copy.bytes == 0) return;
  if (!rows.empty()) {
    RowCopy& last = rows.back();
    if (last.from + last.bytes == copy.from && last.to + last.bytes == copy.to &&
        last.from_row == copy.from_row && last.to_row == copy.to_row &&
        last.int_to_float == copy.int_to_float && last.bytes < last.from_row) {
      last.bytes += copy.bytes;
      return;
    }
  }
  rows.push_back(copy);
}

void OutputCopies::copy(Range envs, const std::uint8_t* final_mask) const noexcept {
  for (const RowCopy& row : rows_) copy_rows(row, envs);
  if (final_rows_.empty()) return;
  for (int env = envs.begin; env < envs.end; ++env) {
    if (final_mask[env] == 0) continue;
    for (const RowCopy& row : final_rows_) copy_rows(row, {env, env + 1});
  }
}

}  // namespace engram
