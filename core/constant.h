// Constants as named data: the class constants of a task, which tests compare with the
// specification, and all that `engram info` prints.
#pragma once

#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace engram {

struct Constant;
using ConstantList = std::vector<Constant>;
using ConstantTable = std::vector<std::pair<std::string, Constant>>;  // in order

// A truth, a number, a text, a list or a table of constants.
struct Constant {
  using Value = std::variant<bool, int, double, std::string, ConstantList, ConstantTable>;
  Value value;

  Constant(bool truth) : value(truth) {}                      // NOLINT: reads like data
  Constant(int number) : value(number) {}                     // NOLINT
  Constant(double number) : value(number) {}                  // NOLINT
  Constant(const char* text) : value(std::string(text)) {}    // NOLINT
  Constant(std::string text) : value(std::move(text)) {}      // NOLINT
  Constant(ConstantList list) : value(std::move(list)) {}     // NOLINT
  Constant(ConstantTable table) : value(std::move(table)) {}  // NOLINT

  // Copies what the variant holds, not the variant: where memory runs out halfway, libstdc++'s
  // destroys a value that is not there.
  Constant(const Constant& other)
      : value(std::visit([](const auto& held) { return Value(held); }, other.value)) {}
  Constant(Constant&& other) noexcept = default;
  Constant& operator=(const Constant& other) = default;
  Constant& operator=(Constant&& other) noexcept = default;
  ~Constant() = default;
};

}  // namespace engram
