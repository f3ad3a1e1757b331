// Runs of commands that tests kill, watched by what they have written and whether they run.
#pragma once

#include <sys/wait.h>

#include <filesystem>
#include <string_view>
#include <system_error>

namespace engram::test {

// Files of this extension below a folder, also while another process writes there.
inline std::size_t files_below(const std::filesystem::path& folder, std::string_view extension) {
  std::size_t count = 0;
  std::error_code ignored;
  for (std::filesystem::recursive_directory_iterator entry(folder, ignored), end;
       entry != end && !ignored; entry.increment(ignored)) {
    count += entry->path().extension() == extension ? 1 : 0;
  }
  return count;
}

// Leaves its status to be waited for.
inline bool has_ended(pid_t child) {
  siginfo_t info{};
  return ::waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
         info.si_pid == child;
}

}  // namespace engram::test
