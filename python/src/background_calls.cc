#include "background_calls.h"

#include <algorithm>
#include <vector>

namespace engram_python {
namespace {

std::vector<unsigned long> threads;  // guarded by the GIL, or without one by the mutex
nanobind::ft_mutex mutex;

}  // namespace

BackgroundCall::BackgroundCall(bool is_needed) : is_marked_(is_needed) {
  if (!is_marked_) return;
  const nanobind::ft_lock_guard lock(mutex);
  threads.push_back(PyThread_get_thread_ident());
}

BackgroundCall::~BackgroundCall() {
  if (!is_marked_) return;
  const nanobind::ft_lock_guard lock(mutex);
  threads.erase(std::ranges::find(threads, PyThread_get_thread_ident()));
}

void interrupt_background_calls(nanobind::handle type) {
  std::vector<unsigned long> running;
  {
    const nanobind::ft_lock_guard lock(mutex);
    running = threads;
  }
  for (const unsigned long thread : running) PyThreadState_SetAsyncExc(thread, type.ptr());
}

}  // namespace engram_python
