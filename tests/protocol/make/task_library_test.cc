#include "protocol/make/task_library.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/base/error.h"
#include "tests/build_paths.h"
#include "tests/env_helpers.h"
#include "tests/temporary_folder.h"

namespace engram {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;

constexpr const char* kId = "TouchSpot-VLA-v0";

fs::path library(const std::string& name) {
  return fs::path(test::kTaskLibraries) / ("lib" + name + ".so");
}

// The library of docs/cpp_tasks.md.
void load_page() { load_tasks(library("touch_spot")); }

// The first bytes of that library.
fs::path cut(const fs::path& folder, std::uintmax_t bytes) {
  const fs::path file = folder / ("libcut_" + std::to_string(bytes) + ".so");
  fs::copy_file(library("touch_spot"), file);
  fs::resize_file(file, bytes);
  return file;
}

// An episode's bytes in the batch's last step, by the number of threads.
test::Bytes played(int threads, int num_envs) {
  const auto batch = test::make_running(kId, {.num_envs = num_envs, .threads = threads});
  for (int i = 0; i < 20; ++i) test::step(*batch, Policy::kOracle);
  return test::batch_bytes(*batch);
}

TEST_CASE("A library's tasks are listed, made and solved by its expert", "[task_library]") {
  load_page();
  const RegistryEntry& entry = require_entry(kId);
  CHECK(entry.family == "TouchSpot");
  CHECK(entry.horizon == 30);
  CHECK_FALSE(entry.canonical);
  CHECK(all_entries()[static_cast<std::size_t>(entry.index)] == &entry);

  const auto batch = test::make_env(kId, {.num_envs = 32});
  CHECK(batch->info().split == "extended");
  batch->reset();
  for (int i = 0; i < batch->info().horizon - 1; ++i) test::step(*batch, Policy::kOracle);
  const ColumnView success = batch->output("success_once");
  for (int i = 0; i < 32; ++i) CHECK(*test::row<std::uint8_t>(success, i) == 1);
}

TEST_CASE("A library's episodes depend neither on threads nor on the batch", "[task_library]") {
  load_page();
  const test::Bytes alone = played(1, 12);
  CHECK(played(3, 12) == alone);
  const test::Bytes first = played(2, 5);
  CHECK(std::equal(first.begin(), first.end(), alone.begin()));
}

TEST_CASE("The same library twice is one", "[task_library]") {
  load_page();
  const RegistryEntry* entry = find_entry(kId);
  const std::size_t count = all_entries().size();
  load_page();
  load_task_list(":" + library("touch_spot").string() + "::" + library("touch_spot").string());
  CHECK(all_entries().size() == count);
  CHECK(find_entry(kId) == entry);
}

TEST_CASE("A library's task has variants, and refuses constants by name", "[task_library]") {
  load_page();
  const TaskVariant variant = {"TouchSpot-Slow-v0", kId, {{"CUE_PHASE_STEPS", ConstantList{6, 8}}}};
  register_variants({&variant, 1});
  CHECK(require_entry("TouchSpot-Slow-v0").family == "TouchSpot");
  CHECK(make_task("TouchSpot-Slow-v0")->info().constants[1].value == Constant(ConstantList{6, 8}));
  // Thrown by the library's own code, and caught here.
  try {
    make_task(kId, {{"GOAL_THRESH", 9.0}});
    FAIL("not refused");
  } catch (const Error& error) {
    CHECK(error.kind() == Error::kInvalidArgument);
    CHECK_THAT(error.what(), Contains("GOAL_THRESH"));
  }
  CHECK_THROWS_WITH(make_task(kId, {{"GOAL_TRESH", 0.05}}), Contains("did you mean 'GOAL_THRESH'"));
}

TEST_CASE("What is no library of tasks of this version is refused by name", "[task_library]") {
  const test::TemporaryFolder folder;
  const fs::path text = folder.path() / "libtext.so";
  std::ofstream(text) << "no library";
  struct Case {
    fs::path file;
    Error::Kind kind;
    std::string message;
  };
  const std::vector<Case> cases = {
      {folder.path() / "none.so", Error::kIo, "cannot be read; a library of tasks needed"},
      {folder.path(), Error::kIo, "cannot be read; a library of tasks needed"},
      {text, Error::kInvalidArgument, "not a library"},
      {cut(folder.path(), 40), Error::kInvalidArgument, "not a library"},
      {cut(folder.path(), 700), Error::kInvalidArgument, "cut off, at 700 bytes"},
      {cut(folder.path(), 9000), Error::kInvalidArgument, "cut off, at 9000 bytes"},
      {library("null_version"), Error::kInvalidArgument, "made for engram ''"},
      {library("null_description"), Error::kInvalidArgument, "returned NULL"},
      {library("no_entry"), Error::kInvalidArgument, "without the function engram_task_library"},
      {library("no_tasks"), Error::kInvalidArgument, "a library without tasks"},
      {library("other_version"), Error::kInvalidArgument, "made for engram '0.0.1', this is '"},
      {library("other_abi"), Error::kInvalidArgument, "aligned to 128 bytes', this engram with"},
      {library("other_headers"), Error::kInvalidArgument, "made with other headers of engram '"},
      {library("taken_id"), Error::kInvalidArgument, "is taken, by a task of the benchmark"}};
  const std::size_t count = all_entries().size();
  for (const Case& one : cases) {
    INFO(one.file);
    try {
      load_tasks(one.file);
      FAIL_CHECK("not refused");
    } catch (const Error& error) {
      CHECK(error.kind() == one.kind);
      CHECK_THAT(error.what(), Contains(one.message) && Contains(one.file.string()));
    }
    CHECK(all_entries().size() == count);
  }
  CHECK(find_entry("FreeId-VLA-v0") == nullptr);
}

}  // namespace
}  // namespace engram
