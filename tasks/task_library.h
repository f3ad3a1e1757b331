// A library of tasks that is compiled outside of this tree, and loaded by engram::load_tasks: one
// of its source files names its families with ENGRAM_TASKS (docs/cpp_tasks.md).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

#include "tasks/family.h"
#include "tasks/task_library_stamp.h"  // written by CMake: version, checksum of the headers

#define ENGRAM_TEXT_OF(macro) ENGRAM_TEXT_OF_VALUE(macro)
#define ENGRAM_TEXT_OF_VALUE(value) #value

// What both sides' compilers have to agree on: names, layouts and calls; the standard library's
// classes; and how Eigen aligns vectors, which depends on instruction sets (-march).
#if defined(_GLIBCXX_DEBUG)
#define ENGRAM_TASKS_STDLIB "libstdc++ with _GLIBCXX_DEBUG"
#elif defined(_GLIBCXX_USE_CXX11_ABI)
#define ENGRAM_TASKS_STDLIB "libstdc++ with CXX11_ABI=" ENGRAM_TEXT_OF(_GLIBCXX_USE_CXX11_ABI)
#else
#define ENGRAM_TASKS_STDLIB "another standard library"
#endif
#define ENGRAM_TASKS_CXX "C++ ABI " ENGRAM_TEXT_OF(__GXX_ABI_VERSION)
#define ENGRAM_TASKS_ALIGNED "vectors aligned to " ENGRAM_TEXT_OF(EIGEN_MAX_STATIC_ALIGN_BYTES)
#define ENGRAM_TASKS_ABI \
  ENGRAM_TASKS_CXX ", " ENGRAM_TASKS_STDLIB ", " ENGRAM_TASKS_ALIGNED " bytes"

#ifdef __FAST_MATH__
#error "-ffast-math changes results from machine to machine: tasks are compiled without it"
#endif

namespace engram {

// What a library says of itself. The order of the members does not change from version to version:
// the texts can be read whatever made the library.
struct TaskLibrary {
  std::uint64_t bytes;  // of this struct
  const char* version;  // of engram
  const char* headers;  // their checksum
  const char* abi;      // ENGRAM_TASKS_ABI
  std::uint64_t count;  // of families
  const Family* const* families;
};

template <std::size_t Count>
constexpr TaskLibrary task_library(const std::array<const Family*, Count>& families) {
  return {.bytes = sizeof(TaskLibrary),
          .version = ENGRAM_TASKS_VERSION,
          .headers = ENGRAM_TASKS_HEADERS,
          .abi = ENGRAM_TASKS_ABI,
          .count = Count,
          .families = families.data()};
}

template <class... Families>
constexpr std::array<const Family*, sizeof...(Families)> families_of(const Families&... families) {
  return {&families...};
}

// The function that a library exports, and its name.
using TaskLibraryFunction = const TaskLibrary*();
inline constexpr const char* kTaskLibraryFunction = "engram_task_library";

}  // namespace engram

// ENGRAM_TASKS(engram::tasks::kTouchSpot, ...); once per library, outside of namespaces.
#define ENGRAM_TASKS(...)                                                                \
  extern "C" __attribute__((visibility("default"))) const ::engram::TaskLibrary*         \
  engram_task_library() {                                                                \
    static constexpr auto kFamilies = ::engram::families_of(__VA_ARGS__);                \
    static constexpr ::engram::TaskLibrary kLibrary = ::engram::task_library(kFamilies); \
    return &kLibrary;                                                                    \
  }                                                                                      \
  static_assert(true)  // takes the semicolon
