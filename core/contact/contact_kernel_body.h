// The kernel of one width, compiled for one instruction set.
#pragma once

#include <type_traits>

#include "core/collision/broad_phase_kernel.h"
#include "core/contact/contact_kernel.h"
#include "core/contact/contact_solver.h"
#include "core/robot/lane_kernel_body.h"

namespace engram {
inline namespace ENGRAM_ISA {

template <class V>
void substep_with_contacts(const RobotModel& robot, const RobotParams& params, bool velocity_mode,
                           double* vectors, const ContactLanes& contacts) {
  substep_with<V>(robot, params, velocity_mode, vectors,
                  [&](const LinkFrames<V>& frames, const JointSolver<V>& joints) {
                    return ContactSolver<V>(contacts, frames, joints, params.single.timestep);
                  });
}

template <class V>
constexpr ContactKernel make_contact_kernel() {
  constexpr int kLanes = simd::kLanesOf<V>;
  using Broad = BroadPhaseKernel<std::conditional_t<kLanes == 1, double, simd::Double>, kLanes>;
  return {kLanes, Broad::pose_robot, Broad::find_near, substep_with_contacts<V>};
}

}  // namespace ENGRAM_ISA
}  // namespace engram
