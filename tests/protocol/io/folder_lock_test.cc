// One process at a time in a folder.
#include "protocol/io/folder_lock.h"

#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>

#include "core/base/error.h"
#include "tests/temporary_folder.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

TEST_CASE("A folder in use is refused with its owner", "[files]") {
  const test::TemporaryFolder folder;
  {
    const FolderLock lock(folder.path());
    CHECK_THROWS_WITH(FolderLock(folder.path()),
                      Catch::Contains(folder.path().string() + "' is in use by process " +
                                      std::to_string(::getpid())) &&
                          Catch::Contains("wait for its end"));
    // A refused lock changes nothing.
    CHECK_THROWS_WITH(FolderLock(folder.path()), Catch::Contains("is in use by process"));
  }
  CHECK(fs::is_empty(folder.path()));
  const FolderLock again(folder.path());
}

TEST_CASE("A lock ends with its process, however that ends", "[files]") {
  const test::TemporaryFolder folder;
  const pid_t killed = ::fork();
  if (killed == 0) {
    const FolderLock lock(folder.path());
    ::raise(SIGKILL);
  }
  REQUIRE(::waitpid(killed, nullptr, 0) == killed);
  CHECK_FALSE(fs::is_empty(folder.path()));  // its note
  std::ofstream(folder.path() / "summary.json.12.engram-tmp") << "half";
  {
    const FolderLock lock(folder.path());
    CHECK_FALSE(fs::exists(folder.path() / "summary.json.12.engram-tmp"));
  }
  CHECK(fs::is_empty(folder.path()));
}

TEST_CASE("A note that another program wrote does no harm", "[files]") {
  const test::TemporaryFolder folder;
  const fs::path victim = folder.path() / "victim";
  std::ofstream(victim) << "precious";
  const fs::path note = folder.path() / "in-use.0.engram-tmp";
  fs::create_symlink(victim, note);
  const auto refusal = [&folder] {
    try {
      const FolderLock second(folder.path());
      return std::string();
    } catch (const Error& error) {
      return std::string(error.what());
    }
  };
  {
    const FolderLock lock(folder.path());
    CHECK_THAT(refusal(), Catch::Contains("in use by another process"));
    fs::remove(note);
    std::ofstream(note) << "process 1 \x1b[2J on host";
    CHECK_THAT(refusal(), Catch::Contains("in use by process 1 ;"));
  }
  CHECK(test::read_file(victim) == "precious");
}

TEST_CASE("A missing folder is named", "[files]") {
  CHECK_THROWS_WITH(FolderLock("/nowhere/at/all"),
                    Catch::Contains("folder '/nowhere/at/all' cannot be opened"));
}

}  // namespace
}  // namespace engram
