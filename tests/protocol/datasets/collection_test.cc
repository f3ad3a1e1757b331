// Collecting when something runs out on the way.
#include "protocol/datasets/collection.h"

#include <catch2/catch.hpp>
#include <cstring>
#include <map>
#include <new>
#include <string>

#include "core/base/error.h"
#include "protocol/make/make.h"
#include "tests/allocation_counter.h"
#include "tests/sanitizers.h"
#include "tests/temporary_folder.h"

namespace engram::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kId = "ShellGamePick-VLA-v0";

// Content of every file of the task's folder, by name.
std::map<std::string, std::string> files_in(const fs::path& root) {
  std::map<std::string, std::string> files;
  const fs::path folder = root / "data_npz" / kId;
  if (!fs::exists(folder)) return files;
  for (const auto& item : fs::directory_iterator(folder)) {
    // What an interrupted run has left for its continuation.
    if (!item.is_regular_file() || item.path().filename() == kJournalFile) continue;
    files[item.path().filename().string()] = read_file(item.path());
  }
  return files;
}

void collect_into(const fs::path& root) {
  Ranks alone;
  const RegistryEntry* const tasks[] = {&require_entry(kId)};
  CollectionOptions options;
  options.plan.episodes = 1;
  options.out = root;
  options.threads = 1;
  (void)collect(alone, tasks, options, [](const CollectionProgress&) {});
}

struct Attempt {
  bool finished = false;
  bool in_mujoco = false;
  bool happened = false;  // it came as far as the failing allocation
  std::int64_t leaked = 0;
};

Attempt try_to_collect(const fs::path& root, std::int64_t number) {
  const std::int64_t held = test::outstanding_allocations();
  Attempt attempt;
  {
    const test::ForgivenLeaks forgiven;  // counted below
    const test::FailingAllocation failing(number);
    try {
      collect_into(root);
      attempt.finished = true;
    } catch (const std::bad_alloc&) {
    } catch (const Error& error) {
      // Images need a scene. MuJoCo's parser may take the failure for one of the scene's text.
      attempt.in_mujoco = error.kind() == Error::kUnavailable ||
                          std::strstr(error.what(), "refused by MuJoCo") != nullptr;
      if (!attempt.in_mujoco) throw;
    }
    attempt.happened = test::FailingAllocation::happened();
  }
  attempt.leaked = test::outstanding_allocations() - held;  // INFO allocates
  return attempt;
}

TEST_CASE("A collection continues after running out of memory", "[collection][allocation]") {
  // Models of the physics are compiled once.
  BatchOptions options = demonstration_options();
  options.num_envs = 1;
  const auto keeper = make(kId, options);
  const TemporaryFolder whole;
  collect_into(whole.path());
  const auto expected = files_in(whole.path());
  REQUIRE(expected.size() == 2);

  std::int64_t number = 1;
  int lost = 0;
  for (Attempt attempt{.happened = true}; attempt.happened; number += 1 + number / 4) {
    const TemporaryFolder root;
    attempt = try_to_collect(root.path(), number);
    INFO("allocation " << number);
    CHECK(attempt.finished != attempt.happened);
    // Leaks of MuJoCo while it compiles a scene do not count.
    if (!attempt.in_mujoco && attempt.leaked != 0) ++lost;
    for (const auto& [name, bytes] : files_in(root.path())) {
      INFO(name);
      CHECK((name == "metadata.json" || bytes == expected.at(name)));
    }
    if (attempt.happened) collect_into(root.path());
    CHECK((files_in(root.path()) == expected));
  }
  // A pool of tinyxml2 loses a block if its list of blocks cannot grow.
  CHECK(lost <= 1);
  CHECK(number > 1000);
}

}  // namespace
}  // namespace engram::test
