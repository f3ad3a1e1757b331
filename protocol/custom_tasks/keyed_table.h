// Tables of JSON that users write: typed values by key, with messages that name key and table.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/io/json.h"

namespace engram {

class KeyedTable {
 public:
  // what: the table's name, for messages. Throws Error (kInvalidArgument) if it is none.
  KeyedTable(const Json& document, std::string what);

  const std::string& what() const { return what_; }
  bool has(std::string_view key) const { return find(document_, key) != nullptr; }
  // Throws Error unless all keys are among these.
  void allow(std::span<const char* const> keys) const;

  // Values that have to be there. Throw Error if one is missing or of another type.
  std::string text(std::string_view key) const;
  double number(std::string_view key) const;
  int integer(std::string_view key, int least, int most) const;
  std::vector<double> numbers(std::string_view key, std::size_t least, std::size_t most) const;
  template <std::size_t Count>
  std::array<double, Count> numbers(std::string_view key) const {
    std::array<double, Count> values;
    std::ranges::copy(numbers(key, Count, Count), values.begin());
    return values;
  }
  const Json& value(std::string_view key) const;
  // An empty list where there is no such key.
  const JsonList& list(std::string_view key) const;

  // Values that need not be there.
  std::string text(std::string_view key, std::string_view otherwise) const;
  double number(std::string_view key, double otherwise) const;
  bool truth(std::string_view key, bool otherwise) const;
  std::vector<std::string> texts(std::string_view key) const;

  // The place of a name among those that are allowed.
  std::size_t choice(std::string_view key, std::span<const char* const> names) const;

  // Throws Error (kInvalidArgument): what: why.
  [[noreturn]] void refuse(const std::string& why) const;

 private:
  const Json& document_;
  std::string what_;
};

}  // namespace engram
