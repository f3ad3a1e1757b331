#include "core/physics/mujoco_handle.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>

#include "core/base/error.h"

namespace engram {
namespace {

thread_local int scope_depth = 0;

using Handler = void (*)(const char*);
Handler previous_error = nullptr;
Handler previous_warning = nullptr;

// MuJoCo is C: it must not continue after an error, so the handler leaves by an exception that
// unwinds through its frames (Debian compiles them with unwind tables).
void on_error(const char* message) {
  if (scope_depth > 0) {
    const bool memory = std::strstr(message, "allocate") != nullptr;
    throw Error(memory ? Error::Kind::kUnavailable : Error::Kind::kInternal,
                std::string("MuJoCo: ") + message);
  }
  if (previous_error != nullptr) {
    previous_error(message);
    return;
  }
  // A thread that is not ours and had no handler: what MuJoCo would do without one.
  std::fprintf(stderr, "ERROR: %s\n\n", message);
  std::exit(EXIT_FAILURE);
}

void on_warning(const char* message) {
  if (scope_depth > 0) return;
  if (previous_warning != nullptr) {
    previous_warning(message);
  } else {
    std::fprintf(stderr, "WARNING: %s\n\n", message);
  }
}

void install_handlers() {
  static std::once_flag once;
  std::call_once(once, [] {
    previous_error = mju_user_error;
    previous_warning = mju_user_warning;
    mju_user_error = on_error;
    mju_user_warning = on_warning;
  });
}

}  // namespace

MujocoScope::MujocoScope() {
  install_handlers();
  ++scope_depth;
}

MujocoScope::~MujocoScope() { --scope_depth; }

ModelPtr compile_model(const std::string& mjcf) {
  const MujocoScope scope;
  // The virtual file system is a few megabytes: too large for a stack.
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  const char* name = "scene.xml";
  mj_makeEmptyFileVFS(files.get(), name, static_cast<int>(mjcf.size()) + 1);
  std::memcpy(files->filedata[0], mjcf.c_str(), mjcf.size() + 1);
  char message[1000] = "";
  ModelPtr model(mj_loadXML(name, files.get(), message, sizeof message));
  mj_deleteVFS(files.get());
  if (model == nullptr) {
    throw Error(Error::Kind::kInternal, std::string("scene refused by MuJoCo: ") + message);
  }
  return model;
}

DataPtr make_data(const mjModel& model) {
  const MujocoScope scope;
  DataPtr data(mj_makeData(&model));
  if (data == nullptr) {
    throw Error(Error::Kind::kUnavailable, "no memory for another mjData");
  }
  return data;
}

}  // namespace engram
