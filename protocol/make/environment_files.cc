#include "protocol/make/environment_files.h"

#include <cstdlib>
#include <mutex>
#include <string_view>

#include "protocol/make/variants.h"

namespace engram {
namespace {

std::string_view variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

}  // namespace

void load_environment_files(PythonLoader load_python) {
  static std::once_flag once;
  std::call_once(once, [load_python] {
    load_task_list(variable("ENGRAM_TASKS"), load_python);
    const std::string_view variants = variable("ENGRAM_VARIANTS");
    if (!variants.empty()) load_variants(variants);
  });
}

}  // namespace engram
