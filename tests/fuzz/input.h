// What fuzz targets share. A target is a function of arbitrary bytes that returns if the library
// behaves: it throws, or trips a sanitizer, if not.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

#include "core/base/error.h"

namespace engram::fuzz {

using Data = std::span<const std::uint8_t>;

inline void require(bool good, const char* what) {
  if (!good) throw std::logic_error(what);
}

// What has become of the calls so far.
struct Tally {
  long accepted = 0;
  long refused = 0;
};
inline Tally tally;

// Runs a call that may refuse what it is given. Returns whether it did not. Anything but an Error
// that tells of bad input is a finding.
template <class F>
bool accepted(F&& f) {
  try {
    f();
    ++tally.accepted;
    return true;
  } catch (const Error& error) {
    ++tally.refused;
    require(error.kind() != Error::kInternal, error.what());
    require(*error.what() != '\0', "an error without a message");
    return false;
  }
}

// Reads the bytes from front to back; behind their end there are zeros.
class Input {
 public:
  explicit Input(Data data) : rest_(data) {}

  bool empty() const { return rest_.empty(); }
  Data rest() const { return rest_; }
  std::string_view rest_text() const {
    return {reinterpret_cast<const char*>(rest_.data()), rest_.size()};
  }

  template <class T>
  requires std::is_arithmetic_v<T> T take() {
    T value{};
    const std::size_t size = std::min(sizeof value, rest_.size());
    if (size > 0) std::memcpy(&value, rest_.data(), size);
    rest_ = rest_.subspan(size);
    return value;
  }
  // A number of 0 to count - 1.
  int choice(std::size_t count) { return static_cast<int>(take<std::uint8_t>() % count); }
  // Up to a byte that tells how many.
  Data bytes() { return take_bytes(take<std::uint8_t>()); }
  Data take_bytes(std::size_t count) {
    const Data taken = rest_.first(std::min(count, rest_.size()));
    rest_ = rest_.subspan(taken.size());
    return taken;
  }
  std::string text() {
    const Data taken = bytes();
    return {reinterpret_cast<const char*>(taken.data()), taken.size()};
  }

 private:
  Data rest_;
};

// A folder for files that a target has read, in memory where the system offers that.
class Folder {
 public:
  Folder() {
    std::error_code none;
    const bool memory = std::filesystem::is_directory("/dev/shm", none);
    std::string name = memory ? "/dev/shm/engram-fuzz-XXXXXX" : "/tmp/engram-fuzz-XXXXXX";
    require(::mkdtemp(name.data()) != nullptr, "no temporary folder");
    path_ = name;
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// Replaces a file, without the care (and the time) that write_file takes.
void put_file(const std::filesystem::path& path, std::string_view content);

// The targets, each in <name>_target.cc.
void fuzz_command_line(Data data);
void fuzz_c_api(Data data);
void fuzz_demonstrations(Data data);
void fuzz_edits(Data data);
void fuzz_npz(Data data);
void fuzz_policy_pipe(Data data);
void fuzz_results(Data data);
void fuzz_snapshot(Data data);

}  // namespace engram::fuzz
