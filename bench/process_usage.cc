#include "bench/process_usage.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <thread>

namespace engram::bench {
namespace {

double resident_bytes() {
  malloc_trim(0);
  std::ifstream statm("/proc/self/statm");
  double pages = 0;
  statm >> pages >> pages;
  return pages * static_cast<double>(sysconf(_SC_PAGESIZE));
}

int listed_threads() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("Threads:")) return std::stoi(line.substr(8));
  }
  return 0;
}

// A thread that has been joined stays listed for a moment: the least of several readings counts.
int threads() {
  constexpr int kReadings = 100;
  int least = std::numeric_limits<int>::max();
  for (int reading = 0; reading < kReadings && least > 1; ++reading) {
    if (reading > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    least = std::min(least, listed_threads());
  }
  return least;
}

// The one that lists them is left out.
int descriptors() {
  const std::filesystem::directory_iterator listed("/proc/self/fd");
  return static_cast<int>(std::distance(begin(listed), end(listed))) - 1;
}

}  // namespace

double allocated_bytes() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
}

ProcessUsage process_usage() {
  return {resident_bytes(), allocated_bytes(), threads(), descriptors()};
}

}  // namespace engram::bench
