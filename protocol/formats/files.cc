#include "protocol/formats/files.h"

#include <dirent.h>
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>

#include "core/base/error.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kTemporarySuffix = ".engram-tmp";

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

fs::path temporary_name(const fs::path& path) {
  return path.string() + "." + std::to_string(::getpid()) + std::string(kTemporarySuffix);
}

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

}  // namespace

int write_all(int descriptor, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return 0;
}

void write_file(const fs::path& path, std::span<const std::byte> bytes) {
  if (is_special(path)) {
    write_into(path, bytes);
    return;
  }
  const fs::path temporary = temporary_name(path);
  const int file = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0) fail("'" + path.string() + "' cannot be written", errno);
  int error = write_all(file, bytes);
  if (error == 0 && ::fsync(file) != 0) error = errno;
  if (::close(file) != 0 && error == 0) error = errno;
  if (error == 0 && std::rename(temporary.c_str(), path.c_str()) != 0) error = errno;
  if (error == 0) return;
  ::unlink(temporary.c_str());
  fail("'" + path.string() + "' cannot be written", error);
}

void write_file(const fs::path& path, std::string_view text) {
  write_file(path, std::as_bytes(std::span<const char>(text)));
}

void require_writable_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) fail("folder '" + folder.string() + "' cannot be made", error.value());
  const fs::path probe = temporary_name(folder / "probe");
  const int file = ::open(probe.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  if (file < 0) fail("folder '" + folder.string() + "' cannot be written", errno);
  ::close(file);
  ::unlink(probe.c_str());
}

std::optional<std::string> read_file(const fs::path& path) {
  const OpenFile file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.descriptor < 0 && (errno == ENOENT || errno == ENOTDIR)) return std::nullopt;
  const auto refuse = [&path](int error) { fail("'" + path.string() + "' cannot be read", error); };
  if (file.descriptor < 0) refuse(errno);
  std::string text;
  char piece[16 * 1024];
  while (true) {
    const ssize_t got = ::read(file.descriptor, piece, sizeof piece);
    if (got == 0) return text;
    if (got > 0) text.append(piece, static_cast<std::size_t>(got));
    if (got < 0 && errno != EINTR) refuse(errno);
  }
}

// libstdc++'s iterator through a folder ends the program if there is no memory for it.
std::vector<std::string> names_in(const fs::path& folder) {
  const std::unique_ptr<DIR, CloseFolder> opened(::opendir(folder.c_str()));
  if (opened == nullptr) fail("folder '" + folder.string() + "' cannot be read", errno);
  std::vector<std::string> names;
  while (const dirent* item = ::readdir(opened.get())) {
    const std::string_view name = item->d_name;
    if (name != "." && name != "..") names.emplace_back(name);
  }
  return names;
}

void remove_temporary_files(const fs::path& folder) {
  for (const std::string& name : names_in(folder)) {
    if (!name.ends_with(kTemporarySuffix)) continue;
    ::unlink((folder / name).c_str());  // somebody else may have been faster
  }
}

}  // namespace engram
