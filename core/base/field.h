// Names and types of the values that a batch exposes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace engram {

enum class DType : std::uint8_t { kBool, kInt32, kUInt64, kFloat32, kFloat64, kUInt8, kInt16 };

// Bytes of one element.
constexpr std::size_t size_of(DType type) {
  switch (type) {
    case DType::kBool:
    case DType::kUInt8:
      return 1;
    case DType::kInt16:
      return 2;
    case DType::kInt32:
    case DType::kFloat32:
      return 4;
    case DType::kUInt64:
    case DType::kFloat64:
      return 8;
  }
  return 0;
}

// The element type by its numpy name: "bool", "int32", ...
const char* dtype_name(DType type);

// One named quantity with `width` elements per environment.
struct Field {
  std::string name;
  int width = 1;
  DType dtype = DType::kFloat32;
  std::string unit;         // "m", "rad", "" where the value has none
  std::string description;  // one phrase
  bool privileged = false;  // holds what a policy has to remember, or how near it is to that
};

template <class T>
constexpr DType dtype_of();
template <>
constexpr DType dtype_of<bool>() {
  return DType::kBool;
}
template <>
constexpr DType dtype_of<std::uint8_t>() {
  return DType::kBool;
}
template <>
constexpr DType dtype_of<std::int32_t>() {
  return DType::kInt32;
}
template <>
constexpr DType dtype_of<std::uint64_t>() {
  return DType::kUInt64;
}
template <>
constexpr DType dtype_of<float>() {
  return DType::kFloat32;
}
template <>
constexpr DType dtype_of<double>() {
  return DType::kFloat64;
}

}  // namespace engram
