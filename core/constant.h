// The class constants of a task, as named data: what `engram info` prints and what tests compare
// with the specification.
#pragma once

#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace engram {

struct Constant;
using ConstantList = std::vector<Constant>;
using ConstantTable = std::vector<std::pair<std::string, Constant>>;  // in order

// A number, a text, a list or a table of constants.
struct Constant {
  std::variant<int, double, std::string, ConstantList, ConstantTable> value;

  Constant(int number) : value(number) {}                     // NOLINT: reads like data
  Constant(double number) : value(number) {}                  // NOLINT
  Constant(const char* text) : value(std::string(text)) {}    // NOLINT
  Constant(std::string text) : value(std::move(text)) {}      // NOLINT
  Constant(ConstantList list) : value(std::move(list)) {}     // NOLINT
  Constant(ConstantTable table) : value(std::move(table)) {}  // NOLINT
};

}  // namespace engram
