#include "tasks/custom/array_exchange.h"

#include <cstring>

#include "core/base/aligned_array.h"
#include "core/base/error.h"

namespace engram::tasks {
namespace {

constexpr std::size_t kAlignment = 64;

constexpr std::size_t rounded(std::size_t bytes) {
  return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

std::byte* row(std::byte* rows, const CustomArray& array, int index) {
  return rows + static_cast<std::size_t>(index) * array.row_bytes();
}

}  // namespace

void ArrayExchange::add(const ColumnStore& store, std::string_view column, bool is_written,
                        std::string_view name) {
  const ColumnView view = store.find(column);
  if (view.field == nullptr) {
    throw Error(Error::kInternal, "no column '" + std::string(column) + "' for a task's rules");
  }
  CustomArray array;
  array.field = *view.field;
  if (!name.empty()) array.field.name = name;
  array.all = view.data;
  array.is_written = is_written;
  array.memory_of_all = store.memory_of(column);
  arrays_.push_back(std::move(array));
}

void ArrayExchange::add_bytes(const ColumnStore& store, std::string_view column, bool is_written) {
  add(store, column, is_written);
  arrays_.back().field.dtype = DType::kUInt8;
}

std::byte* ArrayExchange::add_own(Field field, bool is_written) {
  CustomArray array;
  array.field = std::move(field);
  array.is_written = is_written;
  auto memory = std::make_shared<AlignedArray<std::byte>>(static_cast<std::size_t>(num_envs_) *
                                                          array.row_bytes());
  array.all = memory->data();
  array.memory_of_all = memory;
  arrays_.push_back(std::move(array));
  return arrays_.back().all;
}

void ArrayExchange::bind(CustomInstance& instance) {
  std::size_t bytes = 0;
  for (const CustomArray& array : arrays_) {
    bytes += rounded(static_cast<std::size_t>(num_envs_) * array.row_bytes());
  }
  std::shared_ptr<std::byte> spare = instance.spare_memory(bytes);
  if (!spare) {
    auto memory = std::make_shared<AlignedArray<std::byte>>(bytes);
    spare = std::shared_ptr<std::byte>(memory, memory->data());
  }
  std::byte* next = spare.get();
  for (CustomArray& array : arrays_) {
    array.subset_rows = next;
    array.memory_of_some = spare;
    next += rounded(static_cast<std::size_t>(num_envs_) * array.row_bytes());
  }
  instance.bind(arrays_, num_envs_);
}

void ArrayExchange::call(CustomInstance& instance, CustomMethod method, std::span<const int> envs) {
  const int count = static_cast<int>(envs.size());
  if (count == num_envs_ && instance.sees_batch()) {
    instance.call(method, count, true);
    return;
  }
  fetch(envs);
  instance.call(method, count, false);
  return_written(envs);
}

void ArrayExchange::fetch(std::span<const int> envs) const {
  for (const CustomArray& array : arrays_) {
    std::byte* to = array.subset_rows;
    for (const int env : envs) {
      std::memcpy(to, row(array.all, array, env), array.row_bytes());
      to += array.row_bytes();
    }
  }
}

void ArrayExchange::return_written(std::span<const int> envs) const {
  for (const CustomArray& array : arrays_) {
    if (!array.is_written) continue;
    const std::byte* from = array.subset_rows;
    for (const int env : envs) {
      std::memcpy(row(array.all, array, env), from, array.row_bytes());
      from += array.row_bytes();
    }
  }
}

}  // namespace engram::tasks
