#include "protocol/io/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cctype>
#include <cerrno>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/base/temporary_file.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

// Note of the owner. Named like a temporary file, so that the next run removes it if this one
// is killed.
constexpr const char* kNote = "in-use.0.engram-tmp";

// The text of the note; without a note, a description of the unknown owner.
std::string holder(const OpenFolder& folder) {
  std::string who;
  constexpr int kPlain = O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;
  const int file = ::openat(folder.descriptor(), kNote, kPlain);
  if (file >= 0) {
    char text[128];
    const ssize_t got = ::read(file, text, sizeof text);
    for (ssize_t i = 0; i < got && std::isprint(static_cast<unsigned char>(text[i])) != 0; ++i) {
      who += text[i];
    }
    ::close(file);
  }
  return who.empty() ? "another process" : who;
}

std::string this_process() {
  char host[65] = {};
  if (::gethostname(host, sizeof host - 1) != 0) host[0] = '\0';
  return "process " + std::to_string(::getpid()) + (host[0] == '\0' ? "" : " on ") + host;
}

}  // namespace

FolderLock::FolderLock(const fs::path& folder) : folder_(folder) {
  // File systems without locks are not this class's matter.
  if (::flock(folder_.descriptor(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    throw Error(Error::kIo, "'" + folder.string() + "' is in use by " + holder(folder_) +
                                "; wait for its end, or choose another folder");
  }
  remove_temporary_files(folder.string());
  const std::string who = this_process();
  constexpr int kNew = O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC;
  const int note = ::openat(folder_.descriptor(), kNote, kNew, 0666);
  if (note < 0) return;
  (void)write_all(note, std::as_bytes(std::span<const char>(who)));  // help, and no more
  ::close(note);
}

FolderLock::~FolderLock() { ::unlinkat(folder_.descriptor(), kNote, 0); }

}  // namespace engram
