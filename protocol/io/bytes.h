// Values as bytes, for messages between processes and threads; little-endian, without gaps.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/base/error.h"

namespace engram {

static_assert(std::endian::native == std::endian::little, "messages are written as they lie");

using Bytes = std::vector<std::byte>;

class ByteWriter {
 public:
  template <class T>
  requires std::is_arithmetic_v<T>
  void put(T value) { append(std::as_bytes(std::span(&value, 1))); }
  // A uint32 length, then the characters.
  void put(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size()));
    append(std::as_bytes(std::span(text.data(), text.size())));
  }
  void append(std::span<const std::byte> bytes);
  template <class T>
  void append(std::span<const T> values) {
    append(std::as_bytes(values));
  }

  Bytes take() { return std::move(bytes_); }
  const Bytes& bytes() const { return bytes_; }
  void clear() { bytes_.clear(); }

 private:
  Bytes bytes_;
};

// Reads what a ByteWriter wrote. Throws Error (kInvalidArgument) where bytes are missing.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <class T>
  requires std::is_arithmetic_v<T> T get() {
    T value{};
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  std::string text() {
    const std::span<const std::byte> bytes = take(get<std::uint32_t>());
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  template <class T>
  std::vector<T> values(std::size_t count) {
    if (count > rest_.size() / sizeof(T)) refuse(count * sizeof(T));
    const std::span<const std::byte> bytes = take(count * sizeof(T));
    std::vector<T> out(count);
    if (count > 0) std::memcpy(out.data(), bytes.data(), bytes.size());
    return out;
  }
  std::span<const std::byte> take(std::size_t count) {
    if (count > rest_.size()) refuse(count);
    const std::span<const std::byte> taken = rest_.first(count);
    rest_ = rest_.subspan(count);
    return taken;
  }
  std::span<const std::byte> rest() const { return rest_; }

 private:
  [[noreturn]] void refuse(std::size_t wanted) const {
    throw Error(Error::kInvalidArgument, "message too short: " + std::to_string(rest_.size()) +
                                             " bytes left, " + std::to_string(wanted) + " needed");
  }

  std::span<const std::byte> rest_;
};

}  // namespace engram
