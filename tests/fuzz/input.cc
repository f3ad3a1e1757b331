#include "tests/fuzz/input.h"

#include <fcntl.h>

namespace engram::fuzz {

void put_file(const std::filesystem::path& path, std::string_view content) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  require(file >= 0, "no temporary file");
  const ssize_t written = ::write(file, content.data(), content.size());
  ::close(file);
  require(written == static_cast<ssize_t>(content.size()), "short write");
}

}  // namespace engram::fuzz
