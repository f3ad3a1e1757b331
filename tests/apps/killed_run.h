// Runs of commands that tests kill, watched by what they have written and whether they run.
#pragma once

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

#include "tests/build_paths.h"

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

// A run of the command in the background, killed at the end at the latest.
class KilledCommand {
 public:
  // arguments: as a shell splits them.
  explicit KilledCommand(const std::string& arguments) {
    const std::string line =
        std::string("exec '") + kCommand + "' " + arguments + " >/dev/null 2>&1 </dev/null";
    std::string shell = "sh";
    std::string option = "-c";
    std::string text = line;
    char* words[] = {shell.data(), option.data(), text.data(), nullptr};
    if (::posix_spawn(&process_, "/bin/sh", nullptr, nullptr, words, environ) != 0) process_ = -1;
  }
  ~KilledCommand() { kill(SIGKILL); }
  KilledCommand(const KilledCommand&) = delete;
  KilledCommand& operator=(const KilledCommand&) = delete;

  bool has_ended() const { return test::has_ended(process_); }
  // Sends the signal and waits for the end. Returns whether it was still running.
  bool kill(int signal) {
    if (process_ <= 0) return false;
    ::kill(process_, signal);
    int status = 0;
    const bool waited = ::waitpid(process_, &status, 0) == process_;
    process_ = -1;
    return waited && WIFSIGNALED(status);
  }

 private:
  pid_t process_ = -1;
};

}  // namespace engram::test
