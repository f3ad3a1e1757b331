// Named constants as data: the class constants of a task, which tests compare with the published
// values, and everything that `engram info` prints.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace engram {

struct Constant;
using ConstantList = std::vector<Constant>;
using ConstantTable = std::vector<std::pair<std::string, Constant>>;  // in order

// Null, a bool, a number, a string, a list or a table of constants.
struct Constant {
  using Value = std::variant<std::nullptr_t, bool, std::int64_t, std::uint64_t, double, std::string,
                             ConstantList, ConstantTable>;
  Value value = nullptr;

  Constant() = default;
  Constant(std::nullptr_t /*nothing*/) {}                        // NOLINT: reads like data
  Constant(bool truth) : value(truth) {}                         // NOLINT
  Constant(double number) : value(number) {}                     // NOLINT
  Constant(const char* text) : value(std::string(text)) {}       // NOLINT
  Constant(std::string_view text) : value(std::string(text)) {}  // NOLINT
  Constant(std::string text) : value(std::move(text)) {}         // NOLINT
  Constant(ConstantList list) : value(std::move(list)) {}        // NOLINT
  Constant(ConstantTable table) : value(std::move(table)) {}     // NOLINT
  // Equal numbers are of one type: uint64_t is for those that int64_t cannot hold.
  template <std::integral T>
  Constant(T number) {  // NOLINT
    if (std::in_range<std::int64_t>(number)) {
      value = static_cast<std::int64_t>(number);
    } else {
      value = static_cast<std::uint64_t>(number);
    }
  }

  // Copies what the variant holds, not the variant: where memory runs out halfway, libstdc++'s
  // destroys a value that is not there.
  Constant(const Constant& other)
      : value(std::visit([](const auto& held) { return Value(held); }, other.value)) {}
  Constant(Constant&& other) noexcept = default;
  Constant& operator=(const Constant& other) { return *this = Constant(other); }
  Constant& operator=(Constant&& other) noexcept = default;
  ~Constant() = default;

  friend bool operator==(const Constant& one, const Constant& other) {
    return one.value == other.value;
  }
};

}  // namespace engram
