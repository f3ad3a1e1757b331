#include "protocol/io/files.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <utility>

#include "core/base/error.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kLargestFile = std::uint64_t{1} << 30;
constexpr std::uint64_t kLargestInput = std::uint64_t{1} << 26;  // no list of variants is longer

[[noreturn]] void fail(const std::string& what, int error) {
  throw Error(Error::kIo, what + ": " + std::strerror(error));
}

struct OpenFile {
  explicit OpenFile(int opened) : descriptor(opened) {}
  ~OpenFile() {
    if (descriptor >= 0) ::close(descriptor);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  const int descriptor;
};

struct CloseFolder {
  void operator()(DIR* folder) const { ::closedir(folder); }
};

// Devices and pipes cannot be replaced, only written to.
void write_into(const fs::path& path, std::span<const std::byte> bytes) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (file < 0) fail("'" + path.string() + "' cannot be written", errno);
  int error = write_all(file, bytes);
  if (::close(file) != 0 && error == 0) error = errno;
  if (error != 0) fail("'" + path.string() + "' cannot be written", error);
}

bool is_special(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

// At most `limit` bytes: pipes and devices have no size, and may never end.
std::string read_all(const fs::path& path, const OpenFile& file, std::uint64_t limit) {
  const std::string refusal = "'" + path.string() + "' cannot be read";
  std::string text;
  char piece[16 * 1024];
  while (true) {
    const ssize_t got = ::read(file.descriptor, piece, sizeof piece);
    if (got == 0) return text;
    if (got > 0) text.append(piece, static_cast<std::size_t>(got));
    if (got < 0 && errno != EINTR) fail(refusal, errno);
    if (text.size() > limit) fail(refusal, EFBIG);
  }
}

bool is_missing(const OpenFile& file) {
  return file.descriptor < 0 && (errno == ENOENT || errno == ENOTDIR);
}

std::optional<std::string> read_regular(int folder, const std::string& name,
                                        const fs::path& shown) {
  const std::string refusal = "'" + shown.string() + "' cannot be read";
  // Without O_NONBLOCK, a pipe without a writer would be waited for.
  const OpenFile file(::openat(folder, name.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  if (is_missing(file)) return std::nullopt;
  struct stat status {};
  if (file.descriptor < 0 || ::fstat(file.descriptor, &status) != 0) fail(refusal, errno);
  if (S_ISDIR(status.st_mode)) fail(refusal, EISDIR);
  if (!S_ISREG(status.st_mode)) throw Error(Error::kIo, refusal + ": it is not a file");
  if (static_cast<std::uint64_t>(status.st_size) > kLargestFile) fail(refusal, EFBIG);
  return read_all(shown, file, kLargestFile);
}

}  // namespace

void write_file(const fs::path& path, std::span<const std::byte> bytes) {
  TemporaryFile file(path.string());
  file.write(bytes);
  file.keep();
}

void write_file(const fs::path& path, std::string_view text) {
  write_file(path, std::as_bytes(std::span<const char>(text)));
}

void write_output(const fs::path& path, std::string_view text) {
  if (is_special(path)) {
    write_into(path, std::as_bytes(std::span<const char>(text)));
    return;
  }
  remove_temporary_files_of(path.string());
  write_file(path, text);
}

void require_writable_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) fail("folder '" + folder.string() + "' cannot be made", error.value());
  const TemporaryFile probe((folder / "probe").string());
}

std::optional<std::string> read_file(const fs::path& path) {
  return read_regular(AT_FDCWD, path.string(), path);
}

std::optional<std::string> read_input(const fs::path& path) {
  const OpenFile file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (is_missing(file)) return std::nullopt;
  if (file.descriptor < 0) fail("'" + path.string() + "' cannot be read", errno);
  return read_all(path, file, kLargestInput);
}

// --- open folders ---

OpenFolder::OpenFolder(const fs::path& folder)
    : OpenFolder(folder, ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  // Files can be written to a folder that must not be listed.
  if (descriptor_ < 0) descriptor_ = ::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
  if (descriptor_ < 0) fail("folder '" + folder.string() + "' cannot be opened", errno);
}

OpenFolder::~OpenFolder() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

OpenFolder::OpenFolder(OpenFolder&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

OpenFolder OpenFolder::subfolder(const std::string& name) const {
  const fs::path shown = path_ / name;
  if (::mkdirat(descriptor_, name.c_str(), 0777) != 0 && errno != EEXIST) {
    fail("folder '" + shown.string() + "' cannot be made", errno);
  }
  constexpr int kFolder = O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC;
  const int descriptor = ::openat(descriptor_, name.c_str(), kFolder);
  if (descriptor < 0 && (errno == ELOOP || errno == ENOTDIR)) {
    throw Error(Error::kIo,
                "'" + shown.string() + "' leads elsewhere; a folder of its own, or none, needed");
  }
  if (descriptor < 0) fail("folder '" + shown.string() + "' cannot be opened", errno);
  return {shown, descriptor};
}

void OpenFolder::write_file(const std::string& name, std::span<const std::byte> bytes) const {
  TemporaryFile file(descriptor_, name, (path_ / name).string());
  file.write(bytes);
  file.keep();
}

void OpenFolder::write_file(const std::string& name, std::string_view text) const {
  write_file(name, std::as_bytes(std::span<const char>(text)));
}

std::optional<std::string> OpenFolder::read_file(const std::string& name) const {
  return read_regular(descriptor_, name, path_ / name);
}

// libstdc++'s iterator through a folder ends the program if there is no memory for it.
std::vector<std::string> OpenFolder::names() const {
  const int listed = ::openat(descriptor_, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const std::unique_ptr<DIR, CloseFolder> opened(listed < 0 ? nullptr : ::fdopendir(listed));
  if (opened == nullptr) {
    const int error = errno;
    if (listed >= 0) ::close(listed);
    fail("folder '" + path_.string() + "' cannot be read", error);
  }
  std::vector<std::string> names;
  while (const dirent* item = ::readdir(opened.get())) {
    const std::string_view name = item->d_name;
    if (name != "." && name != "..") names.emplace_back(name);
  }
  return names;
}

}  // namespace engram
