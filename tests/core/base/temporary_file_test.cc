// Files that appear complete: obstacles to them, and leftovers.
#include "core/base/temporary_file.h"

#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <vector>

#include "core/base/error.h"
#include "tests/temporary_folder.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> names_of(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

void write(TemporaryFile& file, std::string_view text) {
  file.write(std::as_bytes(std::span(text.data(), text.size())));
}

TEST_CASE("A temporary file gets its name with all its bytes, or none", "[files]") {
  const test::TemporaryFolder folder;
  const fs::path path = folder.path() / "file";
  {
    TemporaryFile file(path.string());
    write(file, "half");
    CHECK_FALSE(fs::exists(path));
    CHECK(test::read_file(file.open_name()) == "half");
  }
  CHECK(fs::is_empty(folder.path()));
  TemporaryFile file(path.string());
  write(file, "whole");
  file.keep();
  CHECK(names_of(folder.path()) == std::vector<std::string>{"file"});
  CHECK(test::read_file(path) == "whole");
  struct stat status {};
  REQUIRE(::stat(path.c_str(), &status) == 0);
  const mode_t mask = ::umask(0);
  ::umask(mask);
  CHECK((status.st_mode & 0777) == (0666 & ~mask));
}

TEST_CASE("A link that has the file's name is replaced, not followed", "[files]") {
  const test::TemporaryFolder folder;
  const fs::path other = folder.path() / "other";
  std::ofstream(other) << "precious";
  fs::create_symlink(other, folder.path() / "file");
  TemporaryFile file((folder.path() / "file").string());
  write(file, "mine");
  file.keep();
  CHECK(test::read_file(other) == "precious");
  CHECK_FALSE(fs::is_symlink(folder.path() / "file"));
  CHECK(test::read_file(folder.path() / "file") == "mine");
}

TEST_CASE("The name of the open file leads to it, whoever has its temporary name", "[files]") {
  const test::TemporaryFolder folder;
  const fs::path other = folder.path() / "other";
  std::ofstream(other) << "precious";
  const TemporaryFile file((folder.path() / "file").string());
  for (const std::string& name : names_of(folder.path())) {
    if (name == "other") continue;
    fs::remove(folder.path() / name);
    fs::create_symlink(other, folder.path() / name);
  }
  std::ofstream(file.open_name()) << "mine";
  CHECK(test::read_file(other) == "precious");
}

TEST_CASE("Two names of temporary files are never the same", "[files]") {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "file").string();
  const TemporaryFile one(path);
  const TemporaryFile other(path);
  CHECK(names_of(folder.path()).size() == 2);
}

TEST_CASE("What a killed process has left goes, what a living one writes stays", "[files]") {
  const test::TemporaryFolder folder;
  const fs::path path = folder.path() / "film.mp4";
  const pid_t killed = ::fork();
  if (killed == 0) {
    const TemporaryFile file(path.string());
    ::raise(SIGKILL);
  }
  int status = 0;
  REQUIRE(::waitpid(killed, &status, 0) == killed);
  REQUIRE(WIFSIGNALED(status));
  REQUIRE(names_of(folder.path()).size() == 1);
  {
    TemporaryFile alive(path.string());
    const TemporaryFile of_another((folder.path() / "other").string());
    remove_temporary_files_of(path.string());
    CHECK(names_of(folder.path()).size() == 2);
    write(alive, "whole");
    alive.keep();
  }
  CHECK(names_of(folder.path()) == std::vector<std::string>{"film.mp4"});
}

TEST_CASE("Only what engram has made is removed", "[files]") {
  const test::TemporaryFolder folder;
  const test::TemporaryFolder elsewhere;
  std::ofstream(elsewhere.path() / "a.7.engram-tmp") << "not in the folder";
  fs::create_symlink(elsewhere.path() / "a.7.engram-tmp", folder.path() / "link.1.engram-tmp");
  fs::create_directory(folder.path() / "folder.2.engram-tmp");
  REQUIRE(::mkfifo((folder.path() / "pipe.3.engram-tmp").c_str(), 0600) == 0);
  for (const char* name : {".engram-tmp", "7.engram-tmp", "a.x.engram-tmp", "a..engram-tmp", "b"}) {
    std::ofstream(folder.path() / name) << "another's";
  }
  const std::vector<std::string> before = names_of(folder.path());
  std::ofstream(folder.path() / "a.7.engram-tmp") << "half";
  std::ofstream(folder.path() / "b.0123456789abcdef.engram-tmp") << "half";
  remove_temporary_files(folder.path().string());
  CHECK(names_of(folder.path()) == before);
  CHECK(fs::exists(elsewhere.path() / "a.7.engram-tmp"));
  remove_temporary_files((folder.path() / "none").string());  // nothing to do
}

TEST_CASE("The error of a file that cannot be made names it", "[files]") {
  CHECK_THROWS_WITH(TemporaryFile("/nowhere/at/all"),
                    Catch::Contains("'/nowhere/at/all' cannot be written: No such file"));
}

}  // namespace
}  // namespace engram
