#include "core/threads/processors.h"

#include <sched.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/temporary_folder.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

// Files that look like a machine's.
struct Machine {
  test::TemporaryFolder folder;

  void write(const std::string& path, const std::string& text) const {
    const fs::path file = fs::path(root()) / path;
    fs::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }
  std::string root() const { return folder.path().string(); }
};

TEST_CASE("A machine without control groups has no quota", "[processors]") {
  CHECK(cgroup_quota(Machine().root()) == 0);
}

TEST_CASE("The quota of a version 2 group counts, and of those around it", "[processors]") {
  const Machine machine;
  machine.write("proc/self/cgroup", "0::/jobs/mine\n");
  machine.write("sys/fs/cgroup/jobs/mine/cpu.max", "max 100000\n");
  CHECK(cgroup_quota(machine.root()) == 0);
  machine.write("sys/fs/cgroup/jobs/cpu.max", "400000 100000\n");
  CHECK(cgroup_quota(machine.root()) == 4);
  machine.write("sys/fs/cgroup/jobs/mine/cpu.max", "150000 100000\n");
  CHECK(cgroup_quota(machine.root()) == 1.5);
}

TEST_CASE("A container that sees its own group as the root has that group's quota",
          "[processors]") {
  const Machine machine;
  machine.write("proc/self/cgroup", "0::/elsewhere\n");
  machine.write("sys/fs/cgroup/cpu.max", "100000 100000\n");
  CHECK(cgroup_quota(machine.root()) == 1);
}

TEST_CASE("The quota of a version 1 group counts", "[processors]") {
  const Machine machine;
  machine.write("proc/self/cgroup", "5:memory:/mine\n4:cpu,cpuacct:/mine\n");
  const std::string group = GENERATE("sys/fs/cgroup/cpu", "sys/fs/cgroup/cpu,cpuacct");
  machine.write(group + "/mine/cpu.cfs_period_us", "100000\n");
  machine.write(group + "/mine/cpu.cfs_quota_us", "-1\n");
  CHECK(cgroup_quota(machine.root()) == 0);
  machine.write(group + "/mine/cpu.cfs_quota_us", "200000\n");
  CHECK(cgroup_quota(machine.root()) == 2);
}

TEST_CASE("Lines that no system writes are no quota", "[processors]") {
  const Machine machine;
  machine.write("proc/self/cgroup", "\n:\n0:\n0::\n0::mine\n");
  machine.write("sys/fs/cgroup/cpu.max", "none\n");
  CHECK(cgroup_quota(machine.root()) == 0);
}

TEST_CASE("The processors of this thread are counted", "[processors]") {
  cpu_set_t before;
  REQUIRE(sched_getaffinity(0, sizeof before, &before) == 0);
  CHECK(usable_processors() == CPU_COUNT(&before));
  CHECK(available_processors() >= 1);
  CHECK(available_processors() <= usable_processors());
  int first = 0;
  while (!CPU_ISSET(first, &before)) ++first;
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(first, &one);
  REQUIRE(sched_setaffinity(0, sizeof one, &one) == 0);
  CHECK(usable_processors() == 1);
  CHECK(available_processors() == 1);
  REQUIRE(sched_setaffinity(0, sizeof before, &before) == 0);
}

}  // namespace
}  // namespace engram
