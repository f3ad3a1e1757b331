// Processors that this process may use.
#pragma once

#include <string>

namespace engram {

// Processors that the calling thread may run on; at least 1.
int usable_processors() noexcept;

// Usable processors within the quotas of the process's control groups (cgroup v1 and v2, rounded
// down): the threads that `threads = 0` means. More would only take each other's time.
int available_processors();

// Quota of the control groups in files under `root` ("" on a real machine), in processors; 0: none.
double cgroup_quota(const std::string& root);

}  // namespace engram
