// Output of the command: standard streams and text tables.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace engram::apps {

// Opens /dev/null in place of standard streams that the caller has closed, so that no file of ours
// takes their descriptors. A closed pipe becomes an error instead of a signal.
void guard_standard_streams();

// Writes to standard output, control characters as JSON writes them. Throws Error if that fails.
void print(std::string_view text);
// Writes bytes to standard output as they are. Throws Error if that fails.
void print_bytes(std::span<const std::byte> bytes);
// Write the text to standard error as one line, likewise; or that memory is out, if it is.
void print_error(std::string_view text) noexcept;
void print_warning(std::string_view text);

// Rows of text in aligned columns.
class Table {
 public:
  struct ColumnHeader {
    std::string name;
    bool right = false;  // aligned to the right, for numbers
  };

  explicit Table(std::vector<ColumnHeader> columns) : columns_(std::move(columns)) {}

  void add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  bool empty() const { return rows_.empty(); }
  // Every line begins with `indent`.
  std::string text(std::string_view indent = "") const;

 private:
  std::vector<ColumnHeader> columns_;
  std::vector<std::vector<std::string>> rows_;
};

// 31234567.8 as "31,234,568".
std::string with_thousands(double value);

}  // namespace engram::apps
