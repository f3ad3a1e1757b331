#include "protocol/datasets/npz.h"

#include <zip.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <optional>

#include "core/base/error.h"
#include "core/base/join.h"

namespace engram {
namespace {

// Level 1: images of rendered scenes shrink nearly as much as with higher ones, in a fraction of
// the time (docs/datasets.md).
constexpr zip_uint32_t kDeflateLevel = 1;
// 1 January 1980, the first date that ZIP archives can have: the same bytes at any time.
constexpr zip_uint16_t kDosDate = (1 << 5) | 1;
using std::string_view_literals::operator""sv;
constexpr std::string_view kMagic = "\x93NUMPY\x01\x00"sv;  // format version 1.0
constexpr std::size_t kAlignment = 64;                      // of an array's data in its member

std::string_view type_code(NpyType type) {
  switch (type) {
    case NpyType::kBool:
      return "|b1";
    case NpyType::kUint8:
      return "|u1";
    case NpyType::kUint16:
      return "<u2";
    case NpyType::kInt32:
      return "<i4";
    case NpyType::kInt64:
      return "<i8";
    case NpyType::kFloat32:
      return "<f4";
    case NpyType::kText:
      break;
  }
  return "<U";
}

std::size_t bytes_per_element(NpyType type) {
  switch (type) {
    case NpyType::kBool:
    case NpyType::kUint8:
      return 1;
    case NpyType::kUint16:
      return 2;
    case NpyType::kInt64:
      return 8;
    case NpyType::kInt32:
    case NpyType::kFloat32:
    case NpyType::kText:
      break;
  }
  return 4;
}

// Syntax of a Python tuple: "()", "(3,)", "(3, 4)".
std::string shape_text(std::span<const std::int64_t> shape) {
  const std::string sizes = join(shape, [](std::int64_t size) { return std::to_string(size); });
  return "(" + sizes + (shape.size() == 1 ? "," : "") + ")";
}

// Version 1.0 of the format: magic, length, a Python dictionary padded with spaces.
std::string npy_header(const NpyArray& array) {
  std::string descr(type_code(array.type));
  if (array.type == NpyType::kText) descr += std::to_string(array.text_length);
  std::string dictionary = "{'descr': '" + descr +
                           "', 'fortran_order': False, 'shape': " + shape_text(array.shape) + ", }";
  const std::size_t used = kMagic.size() + 2 + dictionary.size() + 1;
  dictionary.append((kAlignment - used % kAlignment) % kAlignment, ' ');
  dictionary += '\n';
  std::string header(kMagic);
  header += static_cast<char>(dictionary.size() & 0xff);
  header += static_cast<char>(dictionary.size() >> 8);
  return header + dictionary;
}

struct SourceDeleter {
  void operator()(zip_source_t* source) const { zip_source_free(source); }
};
using Source = std::unique_ptr<zip_source_t, SourceDeleter>;

[[noreturn]] void fail_to_write(const std::string& what) {
  throw Error(Error::kInternal, "archive cannot be made: " + what);
}

void require(bool ok, zip_t* archive) {
  if (!ok) fail_to_write(zip_strerror(archive));
}

void add_member(zip_t* archive, const NpyArray& array, std::string& header,
                NpzCompression compression) {
  const std::array<zip_buffer_fragment_t, 2> fragments = {
      {{reinterpret_cast<zip_uint8_t*>(header.data()), header.size()},
       {const_cast<zip_uint8_t*>(reinterpret_cast<const zip_uint8_t*>(array.data.data())),
        array.data.size()}}};
  const auto count = array.data.empty() ? std::size_t{1} : fragments.size();
  Source source(zip_source_buffer_fragment(archive, fragments.data(), count, 0));
  require(source != nullptr, archive);
  const zip_int64_t index =
      zip_file_add(archive, (array.name + ".npy").c_str(), source.get(), ZIP_FL_ENC_UTF_8);
  require(index >= 0, archive);
  (void)source.release();  // the archive's now
  const auto member = static_cast<zip_uint64_t>(index);
  const bool deflated = compression == NpzCompression::kDeflated;
  require(zip_set_file_compression(archive, member, deflated ? ZIP_CM_DEFLATE : ZIP_CM_STORE,
                                   deflated ? kDeflateLevel : 0) == 0,
          archive);
  require(zip_file_set_dostime(archive, member, 0, kDosDate, 0) == 0, archive);
}

std::vector<std::byte> content(zip_source_t* source) {
  zip_stat_t stat;
  if (zip_source_stat(source, &stat) != 0 || (stat.valid & ZIP_STAT_SIZE) == 0 ||
      zip_source_open(source) != 0) {
    fail_to_write(zip_error_strerror(zip_source_error(source)));
  }
  std::vector<std::byte> bytes(stat.size);
  const zip_int64_t size = zip_source_read(source, bytes.data(), bytes.size());
  zip_source_close(source);
  if (size != static_cast<zip_int64_t>(bytes.size())) fail_to_write("short read");
  return bytes;
}

// The value behind 'key': in a header, up to a closing character.
std::string_view value_of(std::string_view header, std::string_view key, char last) {
  const std::size_t at = header.find(key);
  if (at == std::string_view::npos) return {};
  const std::size_t begin = at + key.size();
  const std::size_t end = header.find(last, begin);
  return end == std::string_view::npos ? std::string_view() : header.substr(begin, end - begin);
}

std::optional<std::vector<std::int64_t>> parse_shape(std::string_view text) {
  std::vector<std::int64_t> shape;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at != end) {
    if (*at == ' ' || *at == ',') {
      ++at;
      continue;
    }
    std::int64_t size = 0;
    const auto [next, error] = std::from_chars(at, end, size);
    if (error != std::errc() || size < 0) return std::nullopt;
    shape.push_back(size);
    at = next;
  }
  return shape;
}

}  // namespace

std::u32string code_points(std::string_view text) {
  std::u32string out;
  for (std::size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i]);
    const std::size_t length = first < 0x80 ? 1 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
    char32_t point = length == 1 ? first : first & (0xffU >> (length + 1));
    bool good = (first < 0x80 || (first >= 0xc2 && first < 0xf5)) && i + length <= text.size();
    for (std::size_t k = 1; good && k < length; ++k) {
      const auto next = static_cast<unsigned char>(text[i + k]);
      good = (next & 0xc0U) == 0x80;
      point = (point << 6U) | (next & 0x3fU);
    }
    out += good ? point : U'\uFFFD';
    i += good ? length : 1;
  }
  return out;
}

// NumPy's texts are all as long as the longest one, padded with zeros.
NpyArray text_array(std::string name, std::span<const std::string> texts, std::u32string& storage) {
  std::vector<std::u32string> points;
  std::size_t length = 1;
  for (const std::string& text : texts) {
    points.push_back(code_points(text));
    length = std::max(length, points.back().size());
  }
  storage.clear();
  for (std::u32string& text : points) {
    text.resize(length);
    storage += text;
  }
  return {std::move(name),
          NpyType::kText,
          {static_cast<std::int64_t>(texts.size())},
          std::as_bytes(std::span<const char32_t>(storage)),
          static_cast<int>(length)};
}

std::vector<std::byte> npz_bytes(std::span<const NpyArray> arrays, NpzCompression compression) {
  zip_error_t error;
  zip_error_init(&error);
  Source source(zip_source_buffer_create(nullptr, 0, 0, &error));
  if (source == nullptr) fail_to_write(zip_error_strerror(&error));
  zip_t* archive = zip_open_from_source(source.get(), ZIP_TRUNCATE, &error);
  if (archive == nullptr) fail_to_write(zip_error_strerror(&error));
  zip_source_keep(source.get());  // ours too, beyond the archive's end
  std::vector<std::string> headers;
  headers.reserve(arrays.size());
  try {
    for (const NpyArray& array : arrays) {
      add_member(archive, array, headers.emplace_back(npy_header(array)), compression);
    }
    require(zip_close(archive) == 0, archive);
  } catch (...) {
    zip_discard(archive);
    throw;
  }
  return content(source.get());
}

// --- reading ---

struct NpzFile::Archive {
  zip_t* zip = nullptr;
  ~Archive() {
    if (zip != nullptr) zip_discard(zip);
  }
};

// An open member, behind its header.
struct NpzFile::Member {
  struct Close {
    void operator()(zip_file_t* open) const { zip_fclose(open); }
  };
  std::unique_ptr<zip_file_t, Close> file;
  std::vector<std::int64_t> shape;
};

NpzFile::NpzFile(const std::filesystem::path& path)
    : path_(path.string()), archive_(std::make_unique<Archive>()) {
  int code = 0;
  archive_->zip = zip_open(path_.c_str(), ZIP_RDONLY | ZIP_CHECKCONS, &code);
  if (archive_->zip != nullptr) return;
  zip_error_t error;
  zip_error_init_with_code(&error, code);
  fail(zip_error_strerror(&error));
}

NpzFile::~NpzFile() = default;

void NpzFile::fail(const std::string& what) const {
  throw Error(Error::kIo, "'" + path_ + "' is not a data file of engram, or damaged: " + what);
}

NpzFile::Member NpzFile::open(const std::string& name, NpyType type) const {
  Member member;
  member.file.reset(zip_fopen(archive_->zip, (name + ".npy").c_str(), 0));
  if (member.file == nullptr) fail("array '" + name + "': " + zip_strerror(archive_->zip));
  std::array<char, kMagic.size() + 2> start{};
  const auto got = [&](void* out, std::size_t size) {
    return zip_fread(member.file.get(), out, size) == static_cast<zip_int64_t>(size);
  };
  if (!got(start.data(), start.size()) ||
      std::memcmp(start.data(), kMagic.data(), kMagic.size()) != 0) {
    fail("array '" + name + "' is not in NumPy's format");
  }
  const auto low = static_cast<unsigned char>(start[kMagic.size()]);
  const auto high = static_cast<unsigned char>(start[kMagic.size() + 1]);
  std::string header(low | static_cast<std::size_t>(high) << 8U, ' ');
  if (!got(header.data(), header.size())) fail("header of array '" + name + "'");
  const std::string_view descr = value_of(header, "'descr': '", '\'');
  const auto shape = parse_shape(value_of(header, "'shape': (", ')'));
  if (descr != type_code(type) || !shape ||
      header.find("'fortran_order': False") == std::string::npos) {
    fail("array '" + name + "' has header " + header.substr(0, header.find('\n')));
  }
  member.shape = *shape;
  return member;
}

std::vector<std::int64_t> NpzFile::shape(const std::string& name, NpyType type) const {
  return open(name, type).shape;
}

std::vector<std::byte> NpzFile::read(const std::string& name, NpyType type,
                                     std::span<const std::int64_t> shape) const {
  const Member member = open(name, type);
  if (!std::equal(shape.begin(), shape.end(), member.shape.begin(), member.shape.end())) {
    fail("array '" + name + "' has shape " + shape_text(member.shape) + ", " + shape_text(shape) +
         " expected");
  }
  std::size_t size = bytes_per_element(type);
  for (const std::int64_t count : shape) {
    constexpr std::size_t kMax = std::size_t{1} << 40;
    if (count > 0 && size > kMax / static_cast<std::size_t>(count)) {
      fail("array '" + name + "' would be larger than any memory");
    }
    size *= static_cast<std::size_t>(count);
  }
  // Memory is taken as the bytes arrive, not on the word of a header.
  constexpr std::size_t kSlice = std::size_t{1} << 22;
  std::vector<std::byte> bytes;
  bool good = true;
  while (good && bytes.size() < size) {
    const std::size_t start = bytes.size();
    bytes.resize(std::min(size, start + kSlice));
    const std::size_t count = bytes.size() - start;
    good = zip_fread(member.file.get(), bytes.data() + start, count) ==
           static_cast<zip_int64_t>(count);
  }
  // One byte more than there are: the checksum is compared at the end.
  std::byte beyond{};
  good = good && zip_fread(member.file.get(), &beyond, 1) == 0;
  if (!good) fail("array '" + name + "': " + zip_file_strerror(member.file.get()));
  return bytes;
}

void NpzFile::copy_scalar(const std::string& name, NpyType type, std::span<std::byte> out) const {
  const std::vector<std::byte> bytes = read(name, type, {});
  if (bytes.size() != out.size()) fail("array '" + name + "' is not a scalar");
  std::copy(bytes.begin(), bytes.end(), out.begin());
}

}  // namespace engram
