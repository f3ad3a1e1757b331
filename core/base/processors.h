// Processors that this process may use.
#pragma once

#include <string>

namespace engram {

// Processors that the calling thread may run on; at least 1.
int usable_processors() noexcept;

// The same, but no more than the quotas of the process's control groups allow (cgroup v1 and v2,
// rounded down): what `threads = 0` means. Threads beyond a quota would only take each other's
// time.
int available_processors();

// Quota of the control groups in files under `root` ("" on a real machine), in processors; 0: none.
double cgroup_quota(const std::string& root);

}  // namespace engram
