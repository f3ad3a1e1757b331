#include "task_failure.h"

#include <memory>
#include <utility>

namespace engram_python {
namespace {

std::unique_ptr<nanobind::python_error> failure;  // guarded by the GIL, or without one by the mutex
nanobind::ft_mutex mutex;

}  // namespace

void keep_task_failure(nanobind::python_error&& error) {
  auto kept = std::make_unique<nanobind::python_error>(std::move(error));
  const nanobind::ft_lock_guard lock(mutex);
  failure.swap(kept);
}

void raise_task_failure() {
  std::unique_ptr<nanobind::python_error> kept;
  {
    const nanobind::ft_lock_guard lock(mutex);
    failure.swap(kept);
  }
  if (kept) throw nanobind::python_error(std::move(*kept));
}

}  // namespace engram_python
