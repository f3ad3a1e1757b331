// Libraries that say they were made for something else: one for each macro, one that is compiled
// with another ABI, and one that merely has no tasks.
#include "tasks/task_library.h"

namespace {

constexpr engram::Family kFamily = {
    .name = "Altered", .memory_type = "Spatial", .tasks = {}, .make = nullptr};
constexpr auto kFamilies = engram::families_of(kFamily);

}  // namespace

extern "C" __attribute__((visibility("default"))) const engram::TaskLibrary* engram_task_library() {
  static engram::TaskLibrary library = engram::task_library(kFamilies);
#if defined(OTHER_VERSION)
  library.version = "0.0.1";
#elif defined(OTHER_HEADERS)
  library.headers = "0123456789abcdef";
#elif defined(NULL_VERSION)
  library.version = nullptr;
#elif defined(NULL_DESCRIPTION)
  return nullptr;
#endif
  return &library;
}
