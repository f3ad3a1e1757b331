// Kernels for every processor: one lane and four; and the choice of a kernel.
#include "core/contact/contact_kernel.h"
#include "core/contact/contact_kernel_body.h"

namespace engram {
namespace {

constexpr ContactKernel kSingle = make_contact_kernel<float>();
constexpr ContactKernel kKernel = make_contact_kernel<simd::Float>();

}  // namespace

const ContactKernel& baseline_single_contact_kernel() { return kSingle; }

const ContactKernel& contact_kernel(int lanes) {
  switch (lanes) {
    case 16:
      return *avx512_contact_kernel();
    case 8:
      return *avx2_contact_kernel();
    case 4:
      return kKernel;
    default:
      return lane_kernel(8) != nullptr ? *avx2_single_contact_kernel() : kSingle;
  }
}

}  // namespace engram
