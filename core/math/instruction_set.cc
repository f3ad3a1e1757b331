#include "core/math/instruction_set.h"

namespace engram {

// The bits are those of the compiler's options for the kernels' files (CMakeLists.txt).
bool is_available(InstructionSet set) {
  switch (set) {
#if defined(__x86_64__) || defined(__i386__)
    case InstructionSet::kAvx2:
      return __builtin_cpu_supports("avx2") != 0;
    case InstructionSet::kAvx512:
      return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
             __builtin_cpu_supports("avx512bw") != 0 && __builtin_cpu_supports("avx512vl") != 0;
#endif
    default:
      return set == InstructionSet::kAuto || set == InstructionSet::kBaseline;
  }
}

const char* name_of(InstructionSet set) {
  switch (set) {
    case InstructionSet::kAuto:
      return "auto";
    case InstructionSet::kBaseline:
      return "baseline";
    case InstructionSet::kAvx2:
      return "avx2";
    case InstructionSet::kAvx512:
      return "avx512";
  }
  return "unknown";
}

}  // namespace engram
