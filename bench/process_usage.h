// Memory, threads and descriptors of this process.
#pragma once

namespace engram::bench {

struct ProcessUsage {
  double resident_bytes = 0;   // without what is free but still held
  double allocated_bytes = 0;  // of the heap, in use
  int threads = 0;
  int descriptors = 0;
};

ProcessUsage process_usage();

// Bytes of the heap in use; cheaper than the whole.
double allocated_bytes();

}  // namespace engram::bench
