// Kernels for every processor: two lanes, and one for comparisons; and the choice of a kernel.
#include "core/contact/contact_kernel.h"
#include "core/contact/contact_kernel_body.h"

namespace engram {
namespace {

constexpr ContactKernel kScalar = make_contact_kernel<double>();
constexpr ContactKernel kKernel = make_contact_kernel<simd::Double>();

}  // namespace

const ContactKernel& contact_kernel(int lanes) {
  switch (lanes) {
    case 8:
      return *avx512_contact_kernel();
    case 4:
      return *avx2_contact_kernel();
    case 2:
      return kKernel;
    default:
      return kScalar;
  }
}

}  // namespace engram
