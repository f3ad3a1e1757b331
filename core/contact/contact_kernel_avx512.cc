// Eight lanes and one, for processors with AVX-512.
#include "core/contact/contact_kernel.h"

#if defined(__AVX512F__)
#include "core/contact/contact_kernel_body.h"

namespace engram {
namespace {
constexpr ContactKernel kKernel = make_contact_kernel<simd::Double>();
constexpr ContactKernel kSingle = make_contact_kernel<double>();
}  // namespace
const ContactKernel* avx512_contact_kernel() { return &kKernel; }
const ContactKernel* avx512_single_contact_kernel() { return &kSingle; }
}  // namespace engram
#else
namespace engram {
const ContactKernel* avx512_contact_kernel() { return nullptr; }
const ContactKernel* avx512_single_contact_kernel() { return nullptr; }
}  // namespace engram
#endif
