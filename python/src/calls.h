// Calls from Python into the library, until the interpreter ends.
//
// When it does, threads may still be in a call: Python does not wait for daemon threads, and ends
// those that ask for its lock then by unwinding their stack, which C++ code answers by abort.
// Therefore the end waits for calls under way, and no thread goes on beyond it: it sleeps until the
// process has ended.
#pragma once

#include <cxxabi.h>
#include <nanobind/nanobind.h>

namespace engram_python {

// Before calls from other threads than this one are held back. Waits for those under way, for some
// seconds at most, without Python's lock. Python calls this at its end.
void end_calls();
// Whether that has happened.
bool calls_have_ended();

// Sleeps for as long as there is a process.
[[noreturn]] void sleep_forever();
// Does so once calls have ended, but for the thread that ended them.
void hold_back();
// The same for threads that hold Python's lock, which they give back.
void hold_back_locked();

// While one lives, its thread is in the library.
class Call {
 public:
  Call();  // does not return once calls have ended
  ~Call();
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;
};

// f(), which asks for Python's lock or calls Python code. Does not return if Python would end the
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
