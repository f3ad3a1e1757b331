// The instruction sets that kernels are compiled for, and the choice among them at run time.
#pragma once

namespace engram {

// All give the same bits. kAuto: the best that this processor has.
enum class InstructionSet { kAuto, kBaseline, kAvx2, kAvx512 };

// True if this processor has it. kAuto and kBaseline always are there.
bool is_available(InstructionSet set);
// "auto", "baseline", "avx2", "avx512"
const char* name_of(InstructionSet set);

}  // namespace engram
