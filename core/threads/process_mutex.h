// Locks of data that all batches of the process share. fork() takes them all.
#pragma once

#include <mutex>

namespace engram {

// Lock order: a thread that holds one may take those listed after it.
enum class ProcessLock {
  kTaskTexts,    // strings that engram_list_json has returned
  kRegistering,  // registration of variants
  kVariants,     // the list of variants
  kTextures,     // textures, while they are painted
  kCompiler,     // MuJoCo's, which compiles one scene at a time
  kModels,       // compiled scenes in use
  kThreads,      // the process's helping threads
};

// A child of fork() has one thread only: it would wait for ever for a lock that another thread held
// at that moment. So fork() takes all locks first and releases them in parent and child.
std::mutex& process_mutex(ProcessLock what) noexcept;

}  // namespace engram
