#include "core/base/temporary_file.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>

#include "core/base/error.h"

namespace engram {
namespace {

// <name>.<digits><suffix>
constexpr std::string_view kSuffix = ".engram-tmp";
constexpr std::string_view kDigits = "0123456789abcdef";
constexpr int kMaxAttempts = 100;

std::string random_digits() {
  std::uint8_t bytes[8];
  std::string digits;
  while (::getrandom(bytes, sizeof bytes, 0) != sizeof bytes) {
  }
  for (const std::uint8_t byte : bytes) {
    digits += kDigits[byte >> 4];
    digits += kDigits[byte & 15];
  }
  return digits;
}

// Tests for a temporary name of the file `of`, or of any file if that is empty.
bool is_temporary(std::string_view name, std::string_view of) {
  if (!name.ends_with(kSuffix)) return false;
  name.remove_suffix(kSuffix.size());
  const std::size_t dot = name.rfind('.');
  if (dot == std::string_view::npos || dot + 1 == name.size()) return false;
  if (name.find_first_not_of(kDigits, dot + 1) != std::string_view::npos) return false;
  return of.empty() || name.substr(0, dot) == of;
}

// Takes the lock that the writer of a temporary file holds. False if another process has it.
bool lock(int descriptor) {
  return ::flock(descriptor, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
}

struct CloseFolder {
  void operator()(DIR* folder) const { ::closedir(folder); }
};

void remove_unless_in_use(int folder, const char* name) {
  const int file = ::openat(folder, name, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return;  // a link, or gone
  struct stat status {};
  if (::fstat(file, &status) == 0 && S_ISREG(status.st_mode) && lock(file)) {
    ::unlinkat(folder, name, 0);
  }
  ::close(file);
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

TemporaryFile::TemporaryFile(std::string path) : TemporaryFile(AT_FDCWD, path, path) {}

TemporaryFile::TemporaryFile(int folder, std::string name, std::string shown)
    : folder_(folder), name_(std::move(name)), shown_(std::move(shown)) {
  for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
    temporary_ = name_ + "." + random_digits() + std::string(kSuffix);
    constexpr int kNew = O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC;
    descriptor_ = ::openat(folder_, temporary_.c_str(), kNew, 0666);
    if (descriptor_ < 0 && errno == EEXIST) continue;
    if (descriptor_ < 0) fail(errno);
    // A process that removes leftovers may have been faster than the lock.
    struct stat status {};
    if (lock(descriptor_) && ::fstat(descriptor_, &status) == 0 && status.st_nlink > 0) return;
    ::unlinkat(folder_, temporary_.c_str(), 0);
    ::close(descriptor_);
    descriptor_ = -1;
  }
  fail(EEXIST);
}

TemporaryFile::~TemporaryFile() {
  if (!kept_) ::unlinkat(folder_, temporary_.c_str(), 0);
  ::close(descriptor_);
}

void TemporaryFile::write(std::span<const std::byte> bytes) {
  if (const int error = write_all(descriptor_, bytes); error != 0) fail(error);
}

std::string TemporaryFile::open_name() const {
  std::string name = "/proc/self/fd/" + std::to_string(descriptor_);
  return ::access(name.c_str(), F_OK) == 0 ? name : temporary_;
}

void TemporaryFile::keep() {
  if (::fsync(descriptor_) != 0) fail(errno);
  if (::renameat(folder_, temporary_.c_str(), folder_, name_.c_str()) != 0) fail(errno);
  kept_ = true;
}

void TemporaryFile::fail(int error) const {
  throw Error(Error::kIo, "'" + shown_ + "' cannot be written: " + std::strerror(error));
}

void remove_temporary_files(const std::string& folder, std::string_view name) {
  const std::unique_ptr<DIR, CloseFolder> opened(::opendir(folder.c_str()));
  if (opened == nullptr) return;  // nothing of ours can be in it
  while (const dirent* item = ::readdir(opened.get())) {
    if (is_temporary(item->d_name, name)) {
      remove_unless_in_use(::dirfd(opened.get()), item->d_name);
    }
  }
}

void remove_temporary_files_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  if (slash == std::string::npos) {
    remove_temporary_files(".", path);
  } else {
    remove_temporary_files(path.substr(0, slash + 1), std::string_view(path).substr(slash + 1));
  }
}

}  // namespace engram
