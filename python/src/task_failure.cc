#include "task_failure.h"

#include <memory>
#include <utility>

namespace engram_python {
namespace {

std::unique_ptr<nanobind::python_error> failure;  // guarded by the GIL

}  // namespace

void keep_task_failure(nanobind::python_error&& error) {
  failure = std::make_unique<nanobind::python_error>(std::move(error));
}

void raise_task_failure() {
  if (!failure) return;
  throw nanobind::python_error(std::move(*std::exchange(failure, nullptr)));
}

}  // namespace engram_python
