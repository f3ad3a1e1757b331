// OpenGL without a display: contexts from EGL, on a GPU or in software.
#pragma once

#include <memory>
#include <string>

#include "render/egl/gl_functions.h"

namespace engram {

// Capabilities of EGL on this machine.
struct EglInfo {
  bool available = false;
  bool software = false;  // drawn by the processor
  std::string platform;   // "device 0" or "surfaceless"
  std::string vendor;     // as OpenGL names itself
  std::string renderer;
  std::string version;
  std::string problem;  // why not available
};

// Never throws. Creates a context and destroys it.
EglInfo query_egl();

enum class GlProfile {
  kCore,           // OpenGL 4.2 or later
  kCompatibility,  // with the fixed pipeline that MuJoCo's renderer needs
};

// A context of its own, sharing nothing. It may be used by different threads, one at a time.
//
// The displays behind contexts are opened on first use and stay open until the program ends,
// because others in the process may use the same ones. Unless the environment sets LP_NUM_THREADS,
// opening them sets it to 0 in this process: Mesa's software renderer then draws in the calling
// thread instead of starting threads for each context. setenv() must not run beside getenv() of
// other threads: a program with such threads should set the variable itself.
class EglContext {
 public:
  // Throws Error (kUnavailable) that says what is missing.
  explicit EglContext(GlProfile profile);
  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  const Gl& gl() const;
  const std::string& platform() const;

  // While one lives, the context is current on this thread; then the one from before is again. It
  // must not be current on another thread.
  class Current {
   public:
    explicit Current(const EglContext& context);
    ~Current();
    Current(const Current&) = delete;
    Current& operator=(const Current&) = delete;
    bool ok() const { return ok_; }

   private:
    const EglContext& context_;
    void* display_;  // what was current before
    void* draw_;
    void* read_;
    void* previous_;
    bool ok_;
  };

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
};

}  // namespace engram
