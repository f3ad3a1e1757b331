// Failures of the C API: a status, and a message for engram_last_error.
#pragma once

#include <string_view>

#include "core/base/ieee_scope.h"
#include "engram/engram_base_c.h"

namespace engram::c {

// Keeps the message for engram_last_error, in one line, and returns the status. Never allocates.
engram_status fail(engram_status status, std::string_view message) noexcept;

// Sets the last error from the exception that is being handled.
engram_status fail_with_current_exception() noexcept;

const char* last_error() noexcept;

// Runs a function that may throw, and turns what it throws into a status. It computes in an
// IeeeScope.
template <class F>
engram_status guarded(F&& f) noexcept {
  const IeeeScope scope;
  try {
    f();
    return ENGRAM_OK;
  } catch (...) {
    return fail_with_current_exception();
  }
}

// Calls a function of the host program, and undoes what it sets of the mode of arithmetic.
template <class F, class... Args>
auto call_host(F f, Args... args) {
  const IeeeScope scope;
  return f(args...);
}

}  // namespace engram::c
