// Locks of what all batches share, which fork() waits for.
#pragma once

#include <mutex>

namespace engram {

// In the order in which they may be held together: who holds one may ask for those below it.
enum class ProcessLock {
  kTaskTexts,    // what engram_list_json has handed out
  kRegistering,  // who registers variants
  kVariants,     // the list of variants
  kTextures,     // textures, while they are painted
  kCompiler,     // MuJoCo's, which compiles one scene at a time
  kModels,       // compiled scenes in use
};

// The lock of one of them. A child of fork() has one thread only: it would wait for ever for a lock
// that another thread held then. So fork() takes all of them first, and gives them back on both
// sides.
std::mutex& process_mutex(ProcessLock what) noexcept;

}  // namespace engram
