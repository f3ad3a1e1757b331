// Calls from Python into the library, until the interpreter ends.
//
// When it does, threads may still be in a call: Python does not wait for daemon threads, and ends
// those that ask for its lock then by unwinding their stack, which C++ code answers by abort.
// Therefore the end waits for running calls, and threads that return later sleep until the process
// has ended.
#pragma once

#include <cxxabi.h>
#include <nanobind/nanobind.h>

namespace engram_python {

// Blocks further calls from other threads. Waits for running ones, a few seconds at most, without
// the GIL. Python calls this at its end.
void end_calls();
// True after end_calls().
bool calls_have_ended();

// Sleeps until the process ends.
[[noreturn]] void sleep_forever();
// Sleeps if calls have ended, except in the thread that ended them.
void hold_back();
// hold_back() for threads that hold the GIL, which they release.
void hold_back_locked();

// Marks its thread as inside the library during its lifetime.
class Call {
 public:
  Call();  // does not return once calls have ended
  ~Call();
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;
};

// Calls f(), which takes the GIL or calls Python code. Does not return if Python would end the
// thread.
template <class F>
decltype(auto) unless_ended(F&& f) {
  try {
    return f();
  } catch (const abi::__forced_unwind&) {
    sleep_forever();  // to go on from here would unwind the library, too
  }
}

// Python's lock, for threads that do not hold it.
class Locked {
 public:
  Locked() : state_(unless_ended([] { return PyGILState_Ensure(); })) {}
  ~Locked() { PyGILState_Release(state_); }
  Locked(const Locked&) = delete;
  Locked& operator=(const Locked&) = delete;

 private:
  PyGILState_STATE state_;
};

// f(), which must not throw, without Python's lock.
template <class F>
void without_lock(F&& f) {
  PyThreadState* const state = PyEval_SaveThread();
  {
    const Call call;
    f();
  }
  hold_back();
  unless_ended([state] { PyEval_RestoreThread(state); });
}

}  // namespace engram_python
