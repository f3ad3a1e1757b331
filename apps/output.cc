#include "apps/output.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <new>

#include "protocol/io/files.h"
#include "protocol/io/printable.h"
#include "protocol/make/make.h"

namespace engram::apps {
namespace {

[[noreturn]] void fail(const std::string& what, int error) {
  throw Error(Error::kIo, fmt::format("{}: {}", what, std::strerror(error)));
}

int write_text(int descriptor, std::string_view text) {
  return write_all(descriptor, std::as_bytes(std::span(text.data(), text.size())));
}

}  // namespace

void guard_standard_streams() {
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);  // beyond the largest file allowed, writes fail
  for (int descriptor = 0; descriptor <= 2; ++descriptor) {
    // The lowest free number is the one that open returns. Read-only: writes still fail.
    if (::fcntl(descriptor, F_GETFD) == -1) (void)::open("/dev/null", O_RDONLY);
  }
}

void print(std::string_view text) {
  const std::string shown = printable(text, true);
  print_bytes(std::as_bytes(std::span(shown)));
}

void print_bytes(std::span<const std::byte> bytes) {
  if (const int error = write_all(STDOUT_FILENO, bytes); error != 0) {
    fail("standard output cannot be written", error);
  }
}

void print_error(std::string_view text) noexcept {
  try {
    std::string words(text);
    std::replace_if(
        words.begin(), words.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
    std::string line = "engram: " + printable(words);
    while (line.back() == ' ') line.pop_back();
    (void)write_text(STDERR_FILENO, line + "\n");
  } catch (const std::bad_alloc&) {
    (void)write_text(STDERR_FILENO, "engram: out of memory\n");
  }
}

void print_warning(std::string_view text) { print_error("warning: " + std::string(text)); }

std::string Table::text(std::string_view indent) const {
  std::vector<std::size_t> widths;
  for (const ColumnHeader& column : columns_) widths.push_back(column.name.size());
  for (const auto& row : rows_) {
    for (std::size_t i = 0; i < widths.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string out;
  const auto add_line = [&](const std::vector<std::string>& cells) {
    std::string line(indent);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (i > 0) line += "  ";
      line += columns_[i].right ? fmt::format("{:>{}}", cells[i], widths[i])
                                : fmt::format("{:<{}}", cells[i], widths[i]);
    }
    while (!line.empty() && line.back() == ' ') line.pop_back();
    out += line + "\n";
  };
  std::vector<std::string> header;
  for (const ColumnHeader& column : columns_) header.push_back(column.name);
  add_line(header);
  for (const auto& row : rows_) add_line(row);
  return out;
}

std::string with_thousands(double value) {
  if (!std::isfinite(value)) return "-";
  const std::string digits = fmt::format("{:.0f}", std::abs(value));
  std::string text = value < 0 ? "-" : "";
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) text += ',';
    text += digits[i];
  }
  return text;
}

}  // namespace engram::apps
