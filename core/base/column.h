// Struct-of-arrays state: one contiguous array per quantity, one row per environment.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "core/base/aligned_array.h"
#include "core/base/field.h"

namespace engram {

// A typed view of one column; shape (num_envs, width). Cheap to copy; owned by a ColumnStore.
template <class T>
class Column {
 public:
  Column() = default;
  Column(T* data, int width) : data_(data), width_(width) {}

  T* row(int env) const { return data_ + static_cast<std::ptrdiff_t>(env) * width_; }
  T& operator[](int env) const { return data_[static_cast<std::ptrdiff_t>(env) * width_]; }
  T* data() const { return data_; }
  int width() const { return width_; }

 private:
  T* data_ = nullptr;
  int width_ = 0;
};

// A column without its C++ type, for bindings to other languages.
struct ColumnView {
  const Field* field = nullptr;
  std::byte* data = nullptr;

  std::byte* row(int env) const {
    return data + static_cast<std::size_t>(env) * static_cast<std::size_t>(field->width) *
                      size_of(field->dtype);
  }
};

// Owns columns. Everything that an environment remembers between steps is in a column, so saving
// the rows of a store saves the environment.
class ColumnStore {
 public:
  explicit ColumnStore(int num_envs) : num_envs_(num_envs) {}

  // Adds a zero-filled column. Throws Error if the name is taken or the width is not positive.
  ColumnView add(Field field);

  template <class T>
  Column<T> add(std::string_view name, int width = 1, std::string_view unit = "",
                std::string_view description = "", bool privileged = false) {
    const ColumnView view = add(Field{std::string(name), width, dtype_of<T>(), std::string(unit),
                                      std::string(description), privileged});
    return Column<T>(reinterpret_cast<T*>(view.data), width);
  }

  // Adds a column that policies are not given: it holds what they have to remember.
  template <class T>
  Column<T> add_privileged(std::string_view name, int width = 1, std::string_view unit = "",
                           std::string_view description = "") {
    return add<T>(name, width, unit, description, true);
  }

  // Adds columns of the same fields as `other` has.
  void add_like(const ColumnStore& other);

  // Sets the values that a column of int32 or bytes may have, both ends included; for columns that
  // serve as indices. Snapshots with other values are refused. Without a limit, int32 may be
  // anything that can be added up without overflow.
  void limit(std::string_view name, std::int32_t low, std::int32_t high);
  // First column of a saved row with a value outside its limits; the field is null if there is
  // none.
  ColumnView find_beyond_limits(std::span<const std::byte> row) const;

  int num_envs() const { return num_envs_; }
  std::size_t size() const { return columns_.size(); }
  ColumnView operator[](std::size_t index) const;
  // The column of that name; its field is null where there is none.
  ColumnView find(std::string_view name) const;
  // Keeps the memory of that column for those that may outlive the store; null where there is none.
  std::shared_ptr<void> memory_of(std::string_view name) const;

  // Bytes of one environment's rows of all columns, in order.
  std::size_t row_bytes() const { return row_bytes_; }
  void save_row(int env, std::span<std::byte> out) const;
  void load_row(int env, std::span<const std::byte> in);
  // Sets all columns of one environment to zero.
  void clear_row(int env);
  // Copies one environment's rows to the same environment of a store with the same fields.
  void copy_row_to(ColumnStore& other, int env) const;

  // A number that differs between stores of different fields.
  std::uint64_t signature() const;

 private:
  struct Entry {
    Field field;
    std::shared_ptr<AlignedArray<std::byte>> memory;
    std::byte* bytes = nullptr;  // in it
    std::size_t row_bytes = 0;
    std::int32_t low = 0;
    std::int32_t high = 0;
  };
  int num_envs_;
  std::size_t row_bytes_ = 0;
  std::deque<Entry> columns_;  // addresses of fields stay valid while columns are added
};

}  // namespace engram
