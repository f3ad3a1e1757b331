// NumPy's .npz files: arrays by name in a ZIP archive, as numpy.load reads them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace engram {

enum class NpyType { kBool, kUint8, kUint16, kInt32, kInt64, kFloat32, kText };

// An array to be written; `data` lies row by row and is not owned. No dimensions: a scalar.
struct NpyArray {
  std::string name;
  NpyType type = NpyType::kUint8;
  std::vector<std::int64_t> shape;
  std::span<const std::byte> data;
  int text_length = 0;  // characters per element of kText, whose data are 32-bit code points
};

// The array of a vector's elements, or of one value.
template <class T>
std::span<const std::byte> bytes_of(const std::vector<T>& values) {
  return std::as_bytes(std::span<const T>(values));
}
template <class T>
std::span<const std::byte> bytes_of(const T& value) {
  return std::as_bytes(std::span<const T>(&value, 1));
}

// UTF-8 as code points, which is what kText holds; a malformed byte becomes U+FFFD.
std::u32string code_points(std::string_view text);

// A row of texts. Its characters are put into `storage`, which outlives it.
NpyArray text_array(std::string name, std::span<const std::string> texts, std::u32string& storage);

enum class NpzCompression { kStored, kDeflated };

// The bytes of a file with these arrays (one at least). The same arrays give the same bytes, at any
// time and on any machine.
std::vector<std::byte> npz_bytes(std::span<const NpyArray> arrays,
                                 NpzCompression compression = NpzCompression::kDeflated);

// Reads the arrays of a file that npz_bytes wrote, except texts. Throws Error (kIo) if it is not
// one or is damaged.
class NpzFile {
 public:
  explicit NpzFile(const std::filesystem::path& path);
  ~NpzFile();
  NpzFile(const NpzFile&) = delete;
  NpzFile& operator=(const NpzFile&) = delete;

  // The shape of an array, which must be of that type. Reads no more than its header.
  std::vector<std::int64_t> shape(const std::string& name, NpyType type) const;
  // The array's bytes, checked against the archive's checksum. Throws if its type or shape differ.
  std::vector<std::byte> read(const std::string& name, NpyType type,
                              std::span<const std::int64_t> shape) const;
  template <class T>
  T scalar(const std::string& name, NpyType type) const {
    T value;
    copy_scalar(name, type, std::as_writable_bytes(std::span<T>(&value, 1)));
    return value;
  }

 private:
  struct Member;
  Member open(const std::string& name, NpyType type) const;
  void copy_scalar(const std::string& name, NpyType type, std::span<std::byte> out) const;
  [[noreturn]] void fail(const std::string& what) const;

  std::string path_;
  struct Archive;
  std::unique_ptr<Archive> archive_;
};

}  // namespace engram
