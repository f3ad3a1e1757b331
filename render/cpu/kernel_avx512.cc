// The ray caster's inner loops for AVX-512; compiled with -mavx512f -mavx512bw -mavx512dq
// -mavx512vl.
#if defined(__AVX512F__) && defined(__AVX512BW__)

#include "render/cpu/kernel_body.h"

namespace engram::cpu {

const Kernel* avx512_kernel() { return &kKernel; }

}  // namespace engram::cpu

#else  // another processor or compiler

#include "render/cpu/frame_data.h"

namespace engram::cpu {

const Kernel* avx512_kernel() { return nullptr; }

}  // namespace engram::cpu

#endif
