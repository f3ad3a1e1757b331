// Sixteen lanes, for processors with AVX-512.
#include "core/contact/contact_kernel.h"

#if defined(__AVX512F__)
#include "core/contact/contact_kernel_body.h"

namespace engram {
namespace {
constexpr ContactKernel kKernel = make_contact_kernel<simd::Float>();
}  // namespace
const ContactKernel* avx512_contact_kernel() { return &kKernel; }
}  // namespace engram
#else
namespace engram {
const ContactKernel* avx512_contact_kernel() { return nullptr; }
}  // namespace engram
#endif
