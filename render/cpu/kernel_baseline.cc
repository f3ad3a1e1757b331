// The ray caster's inner loops for every machine.
#include "render/cpu/kernel_body.h"

namespace engram::cpu {

const Kernel* baseline_kernel() { return &kKernel; }

}  // namespace engram::cpu
