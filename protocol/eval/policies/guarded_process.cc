#include "protocol/eval/policies/guarded_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <thread>

#include "core/base/error.h"

namespace engram {
namespace {

// --- the guard: a fork of a process with threads, so system calls only ---

constexpr std::array kEndings = {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGUSR1};
constexpr int kCannotStart = 127;  // exit code of a shell without its program

void close_all_from(unsigned first) {
#ifdef SYS_close_range
  if (::syscall(SYS_close_range, first, ~0U, 0U) == 0) return;
#endif
  rlimit limit{};
  const bool known = ::getrlimit(RLIMIT_NOFILE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
  const int end = known ? static_cast<int>(limit.rlim_cur) : 65536;
  for (int descriptor = static_cast<int>(first); descriptor < end; ++descriptor) {
    ::close(descriptor);
  }
}

[[noreturn]] void run_command(char* const* arguments, int input, int output,
                              const sigset_t& unblocked) {
  ::setpgid(0, 0);                     // signals to the group are not for the guard
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // if something kills the guard
  ::dup2(input, STDIN_FILENO);
  ::dup2(output, STDOUT_FILENO);
  for (const int number : kEndings) std::signal(number, SIG_DFL);
  std::signal(SIGPIPE, SIG_DFL);
  ::sigprocmask(SIG_SETMASK, &unblocked, nullptr);
  ::execve("/bin/sh", arguments, ::environ);
  ::_exit(kCannotStart);
}

// Kills the children that /proc lists: processes whose own parents have ended among them.
void kill_children() {
  const int list = ::open("/proc/thread-self/children", O_RDONLY | O_CLOEXEC);
  if (list < 0) return;
  pid_t child = 0;
  char piece[512];
  for (ssize_t got = 0; (got = ::read(list, piece, sizeof piece)) > 0;) {
    for (ssize_t i = 0; i < got; ++i) {
      const char c = piece[i];
      if (c >= '0' && c <= '9') {
        child = 10 * child + (c - '0');
      } else if (child > 0) {
        ::kill(child, SIGKILL);
        child = 0;
      }
    }
  }
  ::close(list);
}

// Until there are none: those that are killed hand their children over to the guard.
void end_descendants() {
  constexpr int kMaxRounds = 2000;  // of a millisecond
  for (int round = 0; round < kMaxRounds; ++round) {
    kill_children();
    pid_t ended = 0;
    while ((ended = ::waitpid(-1, nullptr, WNOHANG)) > 0) {
    }
    if (ended < 0) return;
    ::poll(nullptr, 0, 1);
  }
}

// Ends the guard in the way in which the command has ended.
[[noreturn]] void end_as(int status) {
  if (!WIFSIGNALED(status)) ::_exit(WEXITSTATUS(status));
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  const int number = WTERMSIG(status);
  std::signal(number, SIG_DFL);
  sigset_t one;
  sigemptyset(&one);
  sigaddset(&one, number);
  ::sigprocmask(SIG_UNBLOCK, &one, nullptr);
  ::kill(::getpid(), number);
  ::_exit(kCannotStart);
}

void ignore_signal(int /*number*/) {}

[[noreturn]] void guard(char* const* arguments, int input, int output, int lifeline,
                        const sigset_t& unblocked) {
  ::setpgid(0, 0);              // Ctrl-C in the terminal is for engram alone
  ::prctl(PR_SET_DUMPABLE, 0);  // its memory is a copy of engram's
  ::prctl(PR_SET_CHILD_SUBREAPER, 1);
  // The guard ends with the others only.
  for (const int number : kEndings) std::signal(number, SIG_IGN);
  std::signal(SIGCHLD, ignore_signal);  // blocked, but for the waits
  sigset_t waiting = unblocked;
  sigdelset(&waiting, SIGCHLD);
  const pid_t command = ::fork();
  if (command == 0) run_command(arguments, input, output, unblocked);
  if (command < 0) ::_exit(kCannotStart);
  // Pipes of this and other policies stay open as long as anybody has their other ends.
  ::dup2(lifeline, STDIN_FILENO);
  close_all_from(STDIN_FILENO + 1);
  for (;;) {
    int status = 0;
    for (pid_t ended = 0; (ended = ::waitpid(-1, &status, WNOHANG)) > 0;) {
      if (ended != command) continue;  // an orphan
      end_descendants();
      end_as(status);
    }
    pollfd closes{STDIN_FILENO, POLLIN, 0};
    if (::ppoll(&closes, 1, nullptr, &waiting) <= 0) continue;
    end_descendants();
    ::_exit(kCannotStart);
  }
}

// --- this process ---

[[noreturn]] void refuse(const std::string& command) {
  throw Error(Error::kUnavailable,
              "policy '" + command + "' cannot be started: " + std::strerror(errno));
}

// All signals are blocked, so that no handler of this process runs in the guard.
class BlockedSignals {
 public:
  BlockedSignals() {
    sigset_t all;
    sigfillset(&all);
    ::pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~BlockedSignals() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;

  const sigset_t& before() const { return before_; }

 private:
  sigset_t before_{};
};

}  // namespace

GuardedProcess::GuardedProcess(const std::string& command, int input, int output) {
  std::string shell = "sh";
  std::string option = "-c";
  std::string text = command;
  char* const arguments[] = {shell.data(), option.data(), text.data(), nullptr};
  std::array<int, 2> lifeline{};
  if (::pipe2(lifeline.data(), O_CLOEXEC) != 0) refuse(command);
  {
    const BlockedSignals blocked;
    guard_ = ::fork();
    if (guard_ == 0) {
      ::close(lifeline[1]);
      guard(arguments, input, output, lifeline[0], blocked.before());
    }
  }
  const int error = errno;
  ::close(lifeline[0]);
  lifeline_ = lifeline[1];
  if (guard_ >= 0) return;
  ::close(lifeline_);
  errno = error;
  refuse(command);
}

GuardedProcess::~GuardedProcess() {
  ::close(lifeline_);
  while (::waitpid(guard_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

// The status stays for waitpid.
std::optional<GuardedProcess::Ending> GuardedProcess::ending() const {
  siginfo_t info{};
  const int error = ::waitid(P_PID, static_cast<id_t>(guard_), &info, WEXITED | WNOHANG | WNOWAIT);
  if (error != 0 || info.si_pid != guard_) return std::nullopt;
  return Ending{info.si_code == CLD_EXITED, info.si_status};
}

void GuardedProcess::wait(std::chrono::milliseconds patience) const {
  const auto end = std::chrono::steady_clock::now() + patience;
  while (!ending() && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

}  // namespace engram
