// Eight lanes and one, for processors with AVX2.
#include "core/contact/contact_kernel.h"

#if defined(__AVX2__)
#include "core/contact/contact_kernel_body.h"

namespace engram {
namespace {
constexpr ContactKernel kKernel = make_contact_kernel<simd::Float>();
constexpr ContactKernel kSingle = make_contact_kernel<float>();
}  // namespace
const ContactKernel* avx2_contact_kernel() { return &kKernel; }
const ContactKernel* avx2_single_contact_kernel() { return &kSingle; }
}  // namespace engram
#else
namespace engram {
const ContactKernel* avx2_contact_kernel() { return nullptr; }
const ContactKernel* avx2_single_contact_kernel() { return nullptr; }
}  // namespace engram
#endif
