// Kernels for every processor: one lane and two; and the choice of a kernel.
#include "core/contact/contact_kernel.h"
#include "core/contact/contact_kernel_body.h"

namespace engram {
namespace {

constexpr ContactKernel kSingle = make_contact_kernel<double>();
constexpr ContactKernel kKernel = make_contact_kernel<simd::Double>();

}  // namespace

const ContactKernel& baseline_single_contact_kernel() { return kSingle; }

const ContactKernel& contact_kernel(int lanes) {
  switch (lanes) {
    case 8:
      return *avx512_contact_kernel();
    case 4:
      return *avx2_contact_kernel();
    case 2:
      return kKernel;
    default:
      if (lane_kernel(8) != nullptr) return *avx512_single_contact_kernel();
      return lane_kernel(4) != nullptr ? *avx2_single_contact_kernel() : kSingle;
  }
}

}  // namespace engram
