#include "core/base/module.h"

#include <dlfcn.h>

#include <catch2/catch.hpp>
#include <string>

namespace engram {
namespace {

TEST_CASE("A module beside the program has the function that it is asked for", "[module]") {
  CHECK(module_function("libengram_video.so", "engram_open_video_stream") != nullptr);
}

TEST_CASE("Without the function or the module the loader says why", "[module]") {
  CHECK(module_function("libengram_video.so", "engram_nothing") == nullptr);
  CHECK_THAT(::dlerror(), Catch::Contains("engram_nothing"));
  CHECK(module_function("libengram_nothing.so", "engram_nothing") == nullptr);
  CHECK_THAT(::dlerror(), Catch::Contains("libengram_nothing.so"));
}

}  // namespace
}  // namespace engram
