#include "core/base/column.h"

#include <cstring>

#include "core/base/checksum.h"
#include "core/base/error.h"
#include "core/base/index.h"

namespace engram {

namespace {

constexpr std::int32_t kLargestCount = 1 << 24;

}  // namespace

const char* dtype_name(DType type) {
  switch (type) {
    case DType::kBool:
      return "bool";
    case DType::kInt32:
      return "int32";
    case DType::kUInt64:
      return "uint64";
    case DType::kFloat32:
      return "float32";
    case DType::kFloat64:
      return "float64";
    case DType::kUInt8:
      return "uint8";
    case DType::kInt16:
      return "int16";
  }
  return "unknown";
}

ColumnView ColumnStore::add(Field field) {
  if (field.width <= 0) {
    throw Error(Error::Kind::kInternal, "column '" + field.name + "': width " +
                                            std::to_string(field.width) +
                                            " given, at least 1 needed");
  }
  if (find(field.name).field != nullptr) {
    throw Error(Error::Kind::kInternal, "column '" + field.name + "' exists already");
  }
  Entry entry;
  const bool wide = field.dtype == DType::kInt32;
  entry.low = wide ? -kLargestCount : 0;
  entry.high = wide ? kLargestCount : 255;
  entry.row_bytes = static_cast<std::size_t>(field.width) * size_of(field.dtype);
  entry.memory = std::make_shared<AlignedArray<std::byte>>(entry.row_bytes * at(num_envs_));
  entry.bytes = entry.memory->data();
  entry.field = std::move(field);
  row_bytes_ += entry.row_bytes;
  columns_.push_back(std::move(entry));
  return (*this)[columns_.size() - 1];
}

void ColumnStore::add_like(const ColumnStore& other) {
  for (const Entry& entry : other.columns_) add(entry.field);
}

void ColumnStore::limit(std::string_view name, std::int32_t low, std::int32_t high) {
  for (Entry& entry : columns_) {
    if (entry.field.name != name) continue;
    entry.low = low;
    entry.high = high;
    return;
  }
  throw Error(Error::Kind::kInternal, "no column '" + std::string(name) + "' to be limited");
}

ColumnView ColumnStore::find_beyond_limits(std::span<const std::byte> row) const {
  const std::byte* from = row.data();
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const Entry& entry = columns_[i];
    const bool wide = entry.field.dtype == DType::kInt32;
    const bool limited = wide || entry.field.dtype == DType::kBool;
    for (std::size_t at = 0; limited && at < entry.row_bytes; at += wide ? 4 : 1) {
      std::int32_t value = 0;
      if (wide) {
        std::memcpy(&value, from + at, sizeof value);
      } else {
        value = std::to_integer<std::int32_t>(from[at]);
      }
      if (value < entry.low || value > entry.high) return (*this)[i];
    }
    from += entry.row_bytes;
  }
  return {};
}

ColumnView ColumnStore::operator[](std::size_t index) const {
  const Entry& entry = columns_[index];
  return {&entry.field, entry.bytes};
}

ColumnView ColumnStore::find(std::string_view name) const {
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    if (columns_[i].field.name == name) return (*this)[i];
  }
  return {};
}

std::shared_ptr<void> ColumnStore::memory_of(std::string_view name) const {
  for (const Entry& entry : columns_) {
    if (entry.field.name == name) return entry.memory;
  }
  return {};
}

void ColumnStore::save_row(int env, std::span<std::byte> out) const {
  std::byte* to = out.data();
  for (const Entry& entry : columns_) {
    std::memcpy(to, entry.bytes + at(env) * entry.row_bytes, entry.row_bytes);
    to += entry.row_bytes;
  }
}

void ColumnStore::load_row(int env, std::span<const std::byte> in) {
  const std::byte* from = in.data();
  for (Entry& entry : columns_) {
    std::memcpy(entry.bytes + at(env) * entry.row_bytes, from, entry.row_bytes);
    from += entry.row_bytes;
  }
}

void ColumnStore::clear_row(int env) {
  for (Entry& entry : columns_) {
    std::memset(entry.bytes + at(env) * entry.row_bytes, 0, entry.row_bytes);
  }
}

void ColumnStore::copy_row_to(ColumnStore& other, int env) const {
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const std::size_t offset = at(env) * columns_[i].row_bytes;
    std::memcpy(other.columns_[i].bytes + offset, columns_[i].bytes + offset,
                columns_[i].row_bytes);
  }
}

std::uint64_t ColumnStore::signature() const {
  std::uint64_t hash = kChecksumSeed;
  for (const Entry& entry : columns_) {
    hash = checksum(entry.field.name, hash);
    hash = checksum(dtype_name(entry.field.dtype), hash);
    hash = checksum(std::to_string(entry.field.width), hash);
  }
  return hash;
}

}  // namespace engram
