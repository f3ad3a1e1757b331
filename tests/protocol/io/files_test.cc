// Files that are either whole or not there.
#include "protocol/io/files.h"

#include <sys/stat.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "core/base/error.h"
#include "tests/temporary_folder.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

TEST_CASE("Files are read as they were written", "[files]") {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "file";
  CHECK_FALSE(read_file(file));
  CHECK_FALSE(read_file(file / "below a file"));
  std::string text = "first";
  write_file(file, text);
  CHECK(read_file(file) == text);
  for (int i = 0; i < 100'000; ++i) text += static_cast<char>(i % 256);  // more than a page
  write_file(file, text);
  CHECK((read_file(file) == text));
  write_file(file, "");
  CHECK(read_file(file) == "");
  CHECK_FALSE(read_file(file / "below a file"));
}

TEST_CASE("Unreadable files are not taken for missing", "[files]") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_WITH(read_file(folder.path()), Catch::Contains("cannot be read: Is a directory"));
  const fs::path loop = folder.path() / "loop";
  fs::create_symlink(loop, loop);
  CHECK_THROWS_WITH(read_file(loop), Catch::Contains("loop' cannot be read"));
  CHECK_THROWS_WITH(OpenFolder(folder.path() / "none"), Catch::Contains("none' cannot be opened"));
}

TEST_CASE("Pipes and devices are no files: neither waited for nor read for ever", "[files]") {
  const test::TemporaryFolder folder;
  const fs::path pipe = folder.path() / "pipe";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  CHECK_THROWS_WITH(read_file(pipe), Catch::Contains("pipe' cannot be read: it is not a file"));
  fs::create_symlink("/dev/zero", folder.path() / "zeros");
  CHECK_THROWS_WITH(read_file(folder.path() / "zeros"), Catch::Contains("it is not a file"));
  const fs::path large = folder.path() / "large";
  std::ofstream(large) << "";
  fs::resize_file(large, std::uintmax_t{1} << 31);  // all of it a hole
  CHECK_THROWS_WITH(read_file(large), Catch::Contains("cannot be read: File too large"));
  // Paths given by users may be pipes.
  CHECK(read_input("/dev/null") == "");
  CHECK_FALSE(read_input(folder.path() / "none"));
  CHECK_THROWS_WITH(read_input("/dev/zero"), "'/dev/zero' cannot be read: File too large");
}

TEST_CASE("Files of engram's own names replace what is there, a user's pipe is written to",
          "[files]") {
  const test::TemporaryFolder folder;
  const fs::path name = folder.path() / "settings.json";
  REQUIRE(::mkfifo(name.c_str(), 0600) == 0);
  write_file(name, "text");
  CHECK(fs::is_regular_file(name));
  CHECK(read_file(name) == "text");
  const fs::path device = folder.path() / "device";
  fs::create_symlink("/dev/null", device);
  write_output(device, "text");
  CHECK(fs::is_symlink(device));
  write_output(name, "other");
  CHECK(read_file(name) == "other");
}

TEST_CASE("Folders list all their names, without half-written files", "[files]") {
  const test::TemporaryFolder folder;
  const auto names = [&folder] {
    std::vector<std::string> all = OpenFolder(folder.path()).names();
    std::sort(all.begin(), all.end());
    return all;
  };
  CHECK(names().empty());
  write_file(folder.path() / ".hidden", "");
  write_file(folder.path() / "whole", "");
  write_file(folder.path() / "whole.7.engram-tmp", "ha");
  fs::create_directory(folder.path() / "within");
  const std::vector<std::string> all = {".hidden", "whole", "whole.7.engram-tmp", "within"};
  CHECK(names() == all);
  remove_temporary_files(folder.path().string());
  CHECK(names() == std::vector<std::string>{".hidden", "whole", "within"});
}

TEST_CASE("An open folder is written to, whatever takes its name", "[files]") {
  const test::TemporaryFolder folder;
  const fs::path name = folder.path() / "run";
  const fs::path moved = folder.path() / "moved";
  const fs::path elsewhere = folder.path() / "elsewhere";
  fs::create_directories(name);
  fs::create_directories(elsewhere);
  const OpenFolder open(name);
  open.write_file("a", "1");
  fs::rename(name, moved);
  fs::create_directory_symlink(elsewhere, name);
  open.write_file("a", "2");
  open.subfolder("inner").write_file("b", "3");
  CHECK(fs::is_empty(elsewhere));
  CHECK(test::read_file(moved / "a") == "2");
  CHECK(test::read_file(moved / "inner" / "b") == "3");
  CHECK(open.read_file("a") == "2");
  CHECK_FALSE(open.read_file("c"));
  CHECK(open.names().size() == 2);
}

TEST_CASE("Folders in an open folder are no links", "[files]") {
  const test::TemporaryFolder folder;
  fs::create_directory_symlink("/tmp", folder.path() / "link");
  std::ofstream(folder.path() / "file") << "text";
  const OpenFolder open(folder.path());
  for (const char* name : {"link", "file"}) {
    CHECK_THROWS_WITH(open.subfolder(name), Catch::Contains("leads elsewhere"));
  }
}

}  // namespace
}  // namespace engram
