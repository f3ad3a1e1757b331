// A shell command that does not outlive this process, nor do the processes that it starts.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>

namespace engram {

// The command runs below a guard, a small process of its own. The guard ends, by force, everything
// that the command has started, whatever session or process group that is in: once the command
// itself has ended, and once this process is gone, even if it was killed.
class GuardedProcess {
 public:
  // Starts the command (for /bin/sh) with these descriptors as its standard input and output.
  // Throws Error (kUnavailable) if the system refuses.
  GuardedProcess(const std::string& command, int input, int output);
  // Ends all processes at once.
  ~GuardedProcess();
  GuardedProcess(const GuardedProcess&) = delete;
  GuardedProcess& operator=(const GuardedProcess&) = delete;

  // The end of the command; nothing while it runs.
  struct Ending {
    bool exited = false;  // or else a signal ended it
    int status = 0;       // exit code, or number of the signal
  };
  std::optional<Ending> ending() const;
  // Waits at most that long for the end.
  void wait(std::chrono::milliseconds patience) const;

 private:
  pid_t guard_ = -1;
  int lifeline_ = -1;  // the guard sees when it closes
};

}  // namespace engram
