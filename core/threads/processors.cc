#include "core/threads/processors.h"

#include <sched.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string_view>
#include <thread>

namespace engram {
namespace {

// The quota that allows less; 0: no quota.
double smaller_quota(double a, double b) {
  if (a == 0 || b == 0) return std::max(a, b);
  return std::min(a, b);
}

double quota_of(double microseconds, double period) {
  return microseconds > 0 && period > 0 ? microseconds / period : 0;
}

// cgroup v2: "max 100000" or "50000 100000".
double quota_v2(const std::string& folder) {
  std::ifstream file(folder + "/cpu.max");
  double microseconds = 0;
  double period = 0;
  return file >> microseconds >> period ? quota_of(microseconds, period) : 0;
}

double number_in(const std::string& path) {
  std::ifstream file(path);
  double value = 0;
  return file >> value ? value : 0;
}

// cgroup v1: -1 for no quota.
double quota_v1(const std::string& folder) {
  return quota_of(number_in(folder + "/cpu.cfs_quota_us"),
                  number_in(folder + "/cpu.cfs_period_us"));
}

// The least quota of a group and of those that contain it. A container may see its own group as the
// root, under another path than that in /proc.
template <class Quota>
double min_quota(const std::string& mount, std::string group, const Quota& quota) {
  double least = quota(mount);
  while (!group.empty() && group != "/") {
    least = smaller_quota(least, quota(mount + group));
    group.erase(group.rfind('/'));
  }
  return least;
}

bool has_controller(std::string_view controllers, std::string_view name) {
  std::stringstream list{std::string(controllers)};
  for (std::string one; std::getline(list, one, ',');) {
    if (one == name) return true;
  }
  return false;
}

}  // namespace

int usable_processors() noexcept {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) == 0) return std::max(1, CPU_COUNT(&set));
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

double cgroup_quota(const std::string& root) {
  // Lines like "4:cpu,cpuacct:/group" (v1) and "0::/group" (v2).
  std::ifstream groups(root + "/proc/self/cgroup");
  const std::string mounts = root + "/sys/fs/cgroup/";
  double least = 0;
  for (std::string line; std::getline(groups, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const std::string group = line.substr(second + 1);
    if (!group.starts_with('/')) continue;
    if (controllers.empty()) {
      least = smaller_quota(least, min_quota(mounts, group, quota_v2));
    } else if (has_controller(controllers, "cpu")) {
      for (const std::string& name : {std::string("cpu"), controllers}) {
        least = smaller_quota(least, min_quota(mounts + name, group, quota_v1));
      }
    }
  }
  return least;
}

int available_processors() {
  const int usable = usable_processors();
  const double quota = cgroup_quota("");
  return quota > 0 ? std::clamp(static_cast<int>(quota), 1, usable) : usable;
}

}  // namespace engram
