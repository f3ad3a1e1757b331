// The columns of a batch that a custom task works on. Where they concern some
// environments only, rows travel to spare ones and back, so that rules never see others.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/base/column.h"
#include "tasks/custom/instance.h"

namespace engram::tasks {

class ArrayExchange {
 public:
  explicit ArrayExchange(int num_envs) : num_envs_(num_envs) {}

  void add(const ColumnStore& store, std::string_view column, bool is_written,
           std::string_view name = {});
  // Adds a column of bytes that are numbers, not truth values.
  void add_bytes(const ColumnStore& store, std::string_view column, bool is_written);
  // Adds an array that no store has, zero at first; returns it.
  std::byte* add_own(Field field, bool is_written);

  // Takes the spare rows from the instance, and binds it.
  void bind(CustomInstance& instance);
  // Calls a method for environments in ascending order.
  void call(CustomInstance& instance, CustomMethod method, std::span<const int> envs);

 private:
  void fetch(std::span<const int> envs) const;
  void return_written(std::span<const int> envs) const;

  int num_envs_;
  std::vector<CustomArray> arrays_;
};

}  // namespace engram::tasks
