// Work of a fixed size that touches no memory: the best that threads can scale on this machine.
#pragma once

#include "core/threads/thread_pool.h"

namespace engram::bench {

inline constexpr int kSpinTurns = 200'000;

// Items per second of 64 items with `turns` dependent operations each.
double spin(ThreadPool& pool, int turns = kSpinTurns);

}  // namespace engram::bench
