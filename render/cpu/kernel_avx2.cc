// The ray caster's inner loops for AVX2; compiled with -mavx2.
#if defined(__AVX2__) && !defined(__AVX512F__)

#include "render/cpu/kernel_body.h"

namespace engram::cpu {

const Kernel* avx2_kernel() { return &kKernel; }

}  // namespace engram::cpu

#else  // another processor or compiler

#include "render/cpu/frame_data.h"

namespace engram::cpu {

const Kernel* avx2_kernel() { return nullptr; }

}  // namespace engram::cpu

#endif
