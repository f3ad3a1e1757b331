#include "core/base/module.h"

#include <dlfcn.h>

#include <filesystem>

namespace engram {

void* module_function(const char* module, const char* function) {
  std::error_code ignored;
  const std::filesystem::path folder =
      std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path();
  std::filesystem::path found = module;
  for (const auto& path : {folder / "../lib/engram" / module, folder / module}) {
    if (std::filesystem::exists(path, ignored)) found = path;
  }
  void* loaded = ::dlopen(found.c_str(), RTLD_NOW | RTLD_LOCAL);
  return loaded != nullptr ? ::dlsym(loaded, function) : nullptr;
}

}  // namespace engram
