// Calls of tasks in Python by the library's own threads, to which Python passes no Ctrl-C on.
#pragma once

#include <nanobind/nanobind.h>

namespace engram_python {

// Marks its thread as in the code of a task during its lifetime. Needs the GIL.
class BackgroundCall {
 public:
  // True for threads that are none of Python's. Does not need the GIL; to be asked before it is
  // taken.
  static bool is_needed() { return PyGILState_GetThisThreadState() == nullptr; }

  explicit BackgroundCall(bool is_needed);
  ~BackgroundCall();
  BackgroundCall(const BackgroundCall&) = delete;
  BackgroundCall& operator=(const BackgroundCall&) = delete;

 private:
  bool is_marked_;
};

// Raises an exception of this type in all such calls. Needs the GIL.
void interrupt_background_calls(nanobind::handle type);

}  // namespace engram_python
