// Conversions of single options of the C API to the engine's types, which refuse values that those
// cannot hold. `what`: the option, for the message.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>

#include "core/base/error.h"
#include "core/base/names.h"
#include "core/sim/control_mode.h"

namespace engram::c {

inline constexpr int kNoLimit = std::numeric_limits<int>::max();

[[noreturn]] inline void refuse(const std::string& what, const std::string& given,
                                const std::string& allowed) {
  throw Error(Error::kInvalidArgument, what + ": " + given + " given, " + allowed);
}

inline const char* text(const std::string& what, const char* value) {
  if (value == nullptr) refuse(what, "NULL", "a text needed");
  return value;
}

// Each option as its type in the engine has it.

inline void convert(const char* /*what*/, std::int32_t given, int& option) { option = given; }
inline void convert(const char* /*what*/, std::uint64_t given, std::uint64_t& option) {
  option = given;
}
inline void convert(const char* /*what*/, double given, double& option) { option = given; }

inline void convert(const char* what, std::int32_t given, bool& option) {
  if (given != 0 && given != 1) refuse(what, std::to_string(given), "0 or 1 allowed");
  option = given == 1;
}

inline void convert(const char* what, std::int32_t given, std::optional<bool>& option) {
  if (given < -1 || given > 1) refuse(what, std::to_string(given), "-1, 0 or 1 allowed");
  option = given < 0 ? std::nullopt : std::optional<bool>(given == 1);
}

inline void convert(const char* what, const char* given, std::string& option) {
  option = text(what, given);
}

inline void convert(const char* /*what*/, const char* given, std::optional<ControlMode>& option) {
  option.reset();
  if (given != nullptr) option = require_named<ControlMode>("control mode", given);
}

// A number of a range.
inline void convert(const char* what, std::int32_t given, int low, int high, int& option) {
  if (given < low || given > high) {
    const bool open = high == kNoLimit;
    refuse(what, std::to_string(given),
           std::to_string(low) + (open ? " or more" : " to " + std::to_string(high)) + " allowed");
  }
  option = given;
}

// A number that stands for a name.
template <class Enum>
requires std::is_enum_v<Enum>
void convert(const char* what, std::int32_t given, Enum& option) {
  const auto last = static_cast<std::int32_t>(names_of(Enum()).size()) - 1;
  if (given < 0 || given > last) {
    refuse(what, std::to_string(given), "0 to " + std::to_string(last) + " allowed");
  }
  option = static_cast<Enum>(given);
}

}  // namespace engram::c
