// The contact law: contacts and friction of the robot's links and of free bodies, solved constraint
// by constraint (projected Gauss-Seidel) in the iterations of JointSolver. contact_lanes.h draws
// the terms; docs/physics.md has the whole law.
//
// A constraint with Jacobian J keeps its summed impulse f, N s. D is the displacement since the
// substep's start, v the velocity, s the compliance of a link, beta kBaumgarte:
//
//   mass = 1 / (J M^-1 J^T + s)
//
//   normals, for each point:
//     gap  = separation + J D                      in the velocity iteration at least 0
//     rate = 1 / dt, or beta / dt where the point overlaps at the start
//     f    = max(0, f - mass (rate gap + J v))     no pull
//
//   friction, for each anchor, both tangents together:
//     lambda = f - beta mass (rate (separation + J D) + J v)
//     f      = lambda, scaled to |f| <= friction * normal impulse; slips where it is scaled
//
//   torsion of a patch with one anchor:
//     f = f - beta mass J v, within friction * normal impulse * reach
//
// The members below hold J and separation times the mass, so that no product needs it again.
#pragma once

#include "core/contact/contact_bodies.h"

namespace engram {
inline namespace ENGRAM_ISA {

// Share of the separation of anchors that one iteration takes out, in pairs with a link.
constexpr float kLinkAnchorBaumgarte = 0.8F;
// Slip counts from this excess of impulse on, N s, and this share of the limit: rounding is none.
constexpr float kSlipTolerance = 1e-9F;
constexpr float kSlipShare = 1e-6F;
// Tangential speed below which friction takes fixed axes, squared, m^2/s^2.
constexpr float kSlowSquared = 1e-4F;

template <class V>
class ContactSolver : public ContactBodies<V> {
 public:
  // `joints` after its prepare(); `frames` and `velocity` at the substep's start.
  ContactSolver(const ContactLanes& lanes, const LinkFrames<V>& frames,
                const JointSolver<V>& joints, float timestep)
      : ContactBodies<V>(lanes, frames, joints, timestep) {
    for (int list = 0; list < PatchLists::kCount; ++list) {
      this->for_each_patch(list, [&](PatchLanes<V>& patch, const PatchMembers& members) {
        prepare_patch(patch, members, joints.begin_v);
      });
    }
  }

  ENGRAM_INLINE void solve_bodies(WideRow<V>& velocity, bool last) {
    solve_list(PatchLists::kMoving, velocity, last);
    solve_list(PatchLists::kFixed, velocity, last);
  }
  ENGRAM_INLINE bool solve_links(int joint, WideRow<V>& velocity, bool last) {
    return solve_list(PatchLists::kLinks + joint, velocity, last);
  }

 private:
  using Bodies = ContactBodies<V>;
  using Bodies::added_angular;
  using Bodies::added_linear;
  using Bodies::added_turn;
  using Bodies::column_;
  using Bodies::compliance_;
  using Bodies::delta_q_;
  using Bodies::dt_;
  using Bodies::frames_;
  using Bodies::gather;
  using Bodies::inertia_of_body;
  using Bodies::inv_mass_;
  using Bodies::lanes_;
  using Bodies::link_difference;
  using Bodies::motion_of;
  using Bodies::response;
  using Bodies::second_order_displacement_;
  using Bodies::set_velocity;
  using Bodies::time_;
  using Bodies::timestep_;
  using typename Bodies::Inertia;
  using typename Bodies::Motion;
  using typename Bodies::Vec;

  // Most lists are empty, which false says. The copy leaves the caller's velocities in registers.
  ENGRAM_INLINE bool solve_list(int list, WideRow<V>& velocity, bool last) {
    if (lanes_.lists.size[list] == 0) return false;
    JointsOf<V> changed;
    velocity.store(changed);
    solve_patches(list, changed, last);
    velocity = WideRow<V>(changed);
    return true;
  }

  [[gnu::noinline]] void solve_patches(int list, JointsOf<V>& velocity, bool last) {
    this->for_each_patch(list, [&](PatchLanes<V>& patch, const PatchMembers& members) {
      solve_any(patch, members, velocity, last);
    });
  }

  // --- preparation ---

  // `point`: where A is pushed; `point_b`: where B is.
  ENGRAM_INLINE void set_constraint(ConstraintLanes<V>& constraint, const PatchLanes<V>& patch,
                                    const PatchMembers& members, const Vec& axis, const Vec& point,
                                    const Vec& point_b) const {
    constraint.added_speed = constraint.added_rate = -dot(axis, patch.kinematic_velocity);
    if (members.links != 0) {
      for (int i = 0; i < kArmJoints; ++i) {
        const Vec column = cross(frames_.axis(i), point - frames_.origin(i));
        constraint.joint[i] = patch.joint_sign[i] * dot(axis, column);
      }
      for (int i = 0; i < kFingers; ++i) {
        constraint.joint[kArmJoints + i] =
            patch.joint_sign[kArmJoints + i] * dot(axis, frames_.finger_axis(i));
      }
      const Vec turn = added_turn(patch, members, point);
      constraint.added_rate += dot(axis, turn);
      constraint.added_speed += dot(axis, turn + added_linear(patch, members));
    }
    constraint.turn_a = constraint.turn_b = {};
    if (members.props_a != 0) {
      const Vec center = gather(members.props_a, members.mixed_a, patch.prop_a,
                                [](const FreeBodyLanes<V>& body) { return body.center; });
      constraint.turn_a = cross(point - center, axis);
    }
    if (members.props_b != 0) {
      const Vec center = gather(members.props_b, members.mixed_b, patch.prop_b,
                                [](const FreeBodyLanes<V>& body) { return body.center; });
      constraint.turn_b = cross(axis, point_b - center);
    }
  }

  // Responses; J times the effective mass, of which a constraint takes this share. `axis`: of
  // forces, 0 for a torque.
  ENGRAM_INLINE V finish_constraint(ConstraintLanes<V>& constraint, const PatchMembers& members,
                                    const Inertia& a, const Inertia& b, V compliance,
                                    const Vec& axis, V share) const {
    V sum = dot(axis, axis) * (a.inv_mass + b.inv_mass);
    if (members.links != 0) {
      for (int i = 0; i < kRobotJoints; ++i) {
        V change = {};
        for (int k = 0; k < kRobotJoints; ++k) change += inv_mass_[i][k] * constraint.joint[k];
        constraint.joint_response[i] = change;
        sum += constraint.joint[i] * change;
      }
    }
    constraint.turn_response_a = response(a, constraint.turn_a);
    constraint.turn_response_b = response(b, constraint.turn_b);
    sum += dot(constraint.turn_a, constraint.turn_response_a) +
           dot(constraint.turn_b, constraint.turn_response_b);
    const V mass = share > 0.0F ? share / (sum + compliance) : V{};
    if (members.links != 0) {
      for (int i = 0; i < kRobotJoints; ++i) constraint.joint[i] *= mass;
    }
    constraint.axis = axis * mass;
    constraint.turn_a = constraint.turn_a * mass;
    constraint.turn_b = constraint.turn_b * mass;
    constraint.added_speed *= mass;
    constraint.added_rate *= mass;
    constraint.impulse = V{};
    return mass;
  }

  void prepare_patch(PatchLanes<V>& patch, const PatchMembers& members,
                     const JointsOf<V>& velocity) {
    const Inertia a = inertia_of_body(members.props_a, members.mixed_a, patch.prop_a);
    const Inertia b = inertia_of_body(members.props_b, members.mixed_b, patch.prop_b);
    V compliance = {};
    for (int link = 0; link < kNumLinks; ++link) {
      if ((members.links >> link & 1U) == 0) continue;
      const auto mine = simd::logical_or(patch.link_a == static_cast<float>(link),
                                         patch.link_b == static_cast<float>(link));
      compliance = mine ? simd::max(compliance, compliance_[link]) : compliance;
    }
    const auto with_link = compliance > 0.0F;
    patch.normal_response_a = patch.normal * a.inv_mass;
    patch.normal_response_b = patch.normal * (-b.inv_mass);
    prepare_normals(patch, members, a, b, compliance, velocity);
    prepare_friction(patch, members, a, b, compliance, velocity, with_link);
    prepare_torsion(patch, members, a, b, compliance);
    patch.slipping = V{};
  }

  void prepare_normals(PatchLanes<V>& patch, const PatchMembers& members, const Inertia& a,
                       const Inertia& b, V compliance, const JointsOf<V>& velocity) {
    V normal_impulse = {};
    for (int i = 0; i < members.num_points; ++i) {
      ConstraintLanes<V>& constraint = patch.normal_constraint[i];
      set_constraint(constraint, patch, members, patch.normal, patch.point[i], patch.point[i]);
      const auto present = patch.num_points > static_cast<float>(i);
      const V gap = present ? patch.gap[i] : V{};
      const V mass = finish_constraint(constraint, members, a, b, compliance, patch.normal,
                                       present ? simd::broadcast<V>(1) : V{});
      constraint.separation = gap * mass;
      constraint.bias_rate =
          gap > 0.0F ? simd::broadcast<V>(1 / dt_) : simd::broadcast<V>(kBaumgarte / dt_);
      if (members.links == 0) continue;
      const V speed = constraint_speed(constraint, patch, members, velocity);
      normal_impulse += simd::max(V{}, -constraint.separation * (1 / timestep_) - speed);
    }
    const auto loaded = simd::logical_and(compliance > 0.0F, patch.num_points > 0.0F);
    patch.min_normal_impulse = loaded ? 0.25F * normal_impulse / patch.num_points : V{};
  }

  void prepare_friction(PatchLanes<V>& patch, const PatchMembers& members, const Inertia& a,
                        const Inertia& b, V compliance, const JointsOf<V>& velocity,
                        auto with_link) {
    if (members.num_anchors == 0) return;
    set_tangents(patch, members, velocity);
    const V bias_rate = with_link ? simd::broadcast<V>(kLinkAnchorBaumgarte / dt_)
                                  : simd::broadcast<V>(kBaumgarte / dt_);
    for (int i = 0; i < members.num_anchors; ++i) {
      const auto present = patch.num_anchors > static_cast<float>(i);
      for (int k = 0; k < 2; ++k) {
        ConstraintLanes<V>& constraint = patch.friction_constraint[i][k];
        const Vec& axis = patch.tangent[k];
        set_constraint(constraint, patch, members, axis, patch.anchor_a[i],
                       patch.anchor_a[i] - patch.apart[i]);
        const V mass = finish_constraint(constraint, members, a, b, compliance, axis,
                                         present ? simd::broadcast<V>(kBaumgarte) : V{});
        const V apart = dot(axis, patch.apart[i]);
        constraint.separation = present ? apart * mass : V{};
        constraint.bias_rate = bias_rate;
      }
    }
    for (int k = 0; k < 2; ++k) {
      patch.tangent_response_a[k] = patch.tangent[k] * a.inv_mass;
      patch.tangent_response_b[k] = patch.tangent[k] * (-b.inv_mass);
    }
  }

  // Axes of friction: along the tangential motion of the centres of mass, and across it.
  void set_tangents(PatchLanes<V>& patch, const PatchMembers& members,
                    const JointsOf<V>& velocity) {
    Vec relative = link_difference(patch, members, [&](int link) {
      Vec sum = {};
      for (int i = 0; i < kRobotJoints; ++i) sum = sum + column_[link][i] * velocity[i];
      return sum;
    });
    relative = relative + added_linear(patch, members) - patch.kinematic_velocity;
    const auto add = [&](unsigned long long props, bool mixed, V body_index, float sign) {
      if (props == 0) return;
      const Vec linear = gather(props, mixed, body_index,
                                [](const FreeBodyLanes<V>& body) { return body.begin_linear; });
      for (int k = 0; k < 3; ++k) relative[k] += sign * linear[k];
    };
    add(members.props_a, members.mixed_a, patch.prop_a, 1);
    add(members.props_b, members.mixed_b, patch.prop_b, -1);
    const Vec& n = patch.normal;
    const Vec tangential = relative - n * dot(n, relative);
    const V squared = dot(tangential, tangential);
    const auto moving = squared > kSlowSquared;
    const auto upright = simd::abs(n.x()) < 0.70710678F;
    const Vec fixed = {upright ? V{} : -n.y(), upright ? -n.z() : n.x(), upright ? n.y() : V{}};
    Vec axis;
    for (int k = 0; k < 3; ++k) axis[k] = moving ? tangential[k] : fixed[k];
    const auto present = patch.num_points > 0.0F;
    const V length = simd::sqrt(dot(axis, axis));
    patch.tangent[0] = axis * (1.0F / (present ? length : simd::broadcast<V>(1)));
    patch.tangent[1] = cross(n, patch.tangent[0]);
  }

  void prepare_torsion(PatchLanes<V>& patch, const PatchMembers& members, const Inertia& a,
                       const Inertia& b, V compliance) {
    patch.torsion_reach = V{};
    if (!members.torsion) return;
    const auto present = simd::logical_and(patch.torsion_radius > 0.0F, patch.num_anchors == 1.0F);
    ConstraintLanes<V>& constraint = patch.torsion_constraint;
    for (int i = 0; i < kArmJoints; ++i) {
      constraint.joint[i] = patch.joint_sign[i] * dot(patch.normal, frames_.axis(i));
    }
    for (int i = 0; i < kFingers; ++i) constraint.joint[kArmJoints + i] = V{};
    constraint.turn_a = patch.normal;
    constraint.turn_b = patch.normal * simd::broadcast<V>(-1);
    constraint.added_rate = constraint.separation = constraint.bias_rate = V{};
    constraint.added_speed = dot(patch.normal, added_angular(patch, members));
    finish_constraint(constraint, members, a, b, compliance, Vec{},
                      present ? simd::broadcast<V>(kBaumgarte) : V{});
    V depth = {};
    for (int i = 0; i < members.num_points; ++i) {
      const auto is_point = patch.num_points > static_cast<float>(i);
      depth = simd::max(depth, is_point ? -patch.gap[i] : V{});
    }
    const V reach = simd::max(patch.torsion_radius, simd::sqrt(depth * patch.torsion_radius));
    patch.torsion_reach = present ? reach : V{};
  }

  // --- iterations ---

  // J times a value of each joint, in three chains of sums.
  ENGRAM_INLINE static V product(const V* j, const JointsOf<V>& joints) {
    static_assert(kRobotJoints == 9);
    const V first = j[0] * joints[0] + j[1] * joints[1] + j[2] * joints[2];
    const V second = j[3] * joints[3] + j[4] * joints[4] + j[5] * joints[5];
    const V third = j[6] * joints[6] + j[7] * joints[7] + j[8] * joints[8];
    return (first + second) + third;
  }

  // J v at the substep's start, times the constraint's mass.
  ENGRAM_INLINE V constraint_speed(const ConstraintLanes<V>& constraint, const PatchLanes<V>& patch,
                                   const PatchMembers& members, const JointsOf<V>& velocity) const {
    V speed = product(constraint.joint, velocity) + constraint.added_speed;
    const auto add = [&](unsigned long long props, bool mixed, V body_index, const Vec& turn,
                         float sign) {
      if (props == 0) return;
      const Motion motion = motion_of(props, mixed, body_index);
      speed += sign * dot(constraint.axis, motion.linear) + dot(turn, motion.angular);
    };
    add(members.props_a, members.mixed_a, patch.prop_a, constraint.turn_a, 1);
    add(members.props_b, members.mixed_b, patch.prop_b, constraint.turn_b, -1);
    return speed;
  }

  // What a patch's bodies are in any lane.
  enum BodyKinds : unsigned { kHasLink = 1, kHasPropA = 2, kHasPropB = 4 };

  // A patch that is being solved: its bodies' motion.
  struct Solving {
    // Leaves motion open: to clear it in every iteration took a tenth of a patch's time.
    ENGRAM_INLINE Solving(const PatchLanes<V>& solved, const PatchMembers& in_lanes)
        : patch(solved), members(in_lanes) {}

    const PatchLanes<V>& patch;
    const PatchMembers& members;
    JointsOf<V> velocity;
    Vec second_order;
    Motion a, b;
  };

  // The separation of a constraint now, times its mass.
  template <unsigned kBodies>
  ENGRAM_INLINE V constraint_separation(const Solving& now,
                                        const ConstraintLanes<V>& constraint) const {
    V separation = constraint.separation + constraint.added_rate * time_;
    if constexpr ((kBodies & kHasLink) != 0) separation += product(constraint.joint, delta_q_);
    if constexpr ((kBodies & kHasPropA) != 0) {
      separation +=
          dot(constraint.axis, now.a.delta_position) + dot(constraint.turn_a, now.a.delta_rotation);
    }
    if constexpr ((kBodies & kHasPropB) != 0) {
      separation +=
          dot(constraint.turn_b, now.b.delta_rotation) - dot(constraint.axis, now.b.delta_position);
    }
    if constexpr ((kBodies & kHasLink) != 0) separation += dot(constraint.axis, now.second_order);
    return separation;
  }

  // J v of a constraint, times its mass.
  template <unsigned kBodies>
  ENGRAM_INLINE V constraint_speed(const Solving& now, const ConstraintLanes<V>& constraint) const {
    V speed = constraint.added_speed;
    if constexpr ((kBodies & kHasPropA) != 0) {
      speed += dot(constraint.axis, now.a.linear) + dot(constraint.turn_a, now.a.angular);
    }
    if constexpr ((kBodies & kHasPropB) != 0) {
      speed += dot(constraint.turn_b, now.b.angular) - dot(constraint.axis, now.b.linear);
    }
    if constexpr ((kBodies & kHasLink) != 0) speed += product(constraint.joint, now.velocity);
    return speed;
  }

  ENGRAM_INLINE static void add_to(Vec& sum, const Vec& direction, V scale) {
    sum = sum + direction * scale;
  }

  // Applies a change of a constraint's impulse. `response_a`, `response_b`: of free bodies'
  // velocities. Most points that do not touch yet have none in any lane.
  template <unsigned kBodies>
  ENGRAM_INLINE void apply(Solving& now, ConstraintLanes<V>& constraint, const Vec& response_a,
                           const Vec& response_b, V change) const {
    if (!simd::any(change != 0.0F)) return;
    constraint.impulse += change;
    if constexpr ((kBodies & kHasPropA) != 0) {
      add_to(now.a.linear, response_a, change);
      add_to(now.a.angular, constraint.turn_response_a, change);
    }
    if constexpr ((kBodies & kHasPropB) != 0) {
      add_to(now.b.linear, response_b, change);
      add_to(now.b.angular, constraint.turn_response_b, change);
    }
    if constexpr ((kBodies & kHasLink) != 0) {
      for (int i = 0; i < kRobotJoints; ++i)
        now.velocity[i] += constraint.joint_response[i] * change;
    }
  }

  // Returns the sum of normal impulses.
  template <unsigned kBodies>
  ENGRAM_INLINE V solve_normals(Solving& now, PatchLanes<V>& patch, bool last) const {
    V normal_impulse = {};
    for (int i = 0; i < now.members.num_points; ++i) {
      ConstraintLanes<V>& constraint = patch.normal_constraint[i];
      V gap = constraint_separation<kBodies>(now, constraint);
      if (last) gap = simd::max(V{}, gap);
      // The impulse stays above zero.
      const V change =
          simd::max(-constraint.impulse,
                    -(constraint.bias_rate * gap) - constraint_speed<kBodies>(now, constraint));
      apply<kBodies>(now, constraint, patch.normal_response_a, patch.normal_response_b, change);
      normal_impulse += constraint.impulse;
    }
    return normal_impulse;
  }

  ENGRAM_INLINE static V slip_limit(V limit) { return limit * (1 + kSlipShare) + kSlipTolerance; }

  // Coulomb's limit on both axes together. Returns 1 where it is exceeded.
  template <unsigned kBodies>
  ENGRAM_INLINE V solve_friction(Solving& now, PatchLanes<V>& patch, V normal_impulse) const {
    const auto two = patch.num_anchors > 1.0F;
    const V limit =
        patch.friction * normal_impulse * (two ? simd::broadcast<V>(0.5F) : simd::broadcast<V>(1));
    V slipping = {};
    for (int i = 0; i < now.members.num_anchors; ++i) {
      V unclamped_impulse[2];
      for (int k = 0; k < 2; ++k) {
        const ConstraintLanes<V>& constraint = patch.friction_constraint[i][k];
        const V biased_impulse =
            constraint.impulse -
            constraint.bias_rate * constraint_separation<kBodies>(now, constraint);
        unclamped_impulse[k] = biased_impulse - constraint_speed<kBodies>(now, constraint);
      }
      const V size = simd::sqrt(unclamped_impulse[0] * unclamped_impulse[0] +
                                unclamped_impulse[1] * unclamped_impulse[1]);
      const auto slips = size > slip_limit(limit);
      const V scale = slips ? limit / size : simd::broadcast<V>(1);
      slipping = slips ? simd::broadcast<V>(1) : slipping;
      for (int k = 0; k < 2; ++k) {
        ConstraintLanes<V>& constraint = patch.friction_constraint[i][k];
        apply<kBodies>(now, constraint, patch.tangent_response_a[k], patch.tangent_response_b[k],
                       unclamped_impulse[k] * scale - constraint.impulse);
      }
    }
    return slipping;
  }

  template <unsigned kBodies>
  ENGRAM_INLINE V solve_torsion(Solving& now, PatchLanes<V>& patch, V normal_impulse) const {
    ConstraintLanes<V>& constraint = patch.torsion_constraint;
    const V limit = patch.friction * normal_impulse * patch.torsion_reach;
    const V unclamped_impulse = constraint.impulse - constraint_speed<kBodies>(now, constraint);
    const V impulse = simd::min(limit, simd::max(-limit, unclamped_impulse));
    apply<kBodies>(now, constraint, Vec{}, Vec{}, impulse - constraint.impulse);
    return simd::abs(unclamped_impulse) > slip_limit(limit) ? simd::broadcast<V>(1) : V{};
  }

  template <unsigned kBodies>
  void solve_patch(PatchLanes<V>& patch, const PatchMembers& members, JointsOf<V>& velocity,
                   bool last) {
    Solving now(patch, members);
    if constexpr ((kBodies & kHasLink) != 0) {
      now.velocity = velocity;
      now.second_order =
          time_ > 0 ? link_difference(patch, members,
                                      [this](int link) { return second_order_displacement_[link]; })
                    : Vec{};
    }
    if constexpr ((kBodies & kHasPropA) != 0) {
      now.a = motion_of(members.props_a, members.mixed_a, patch.prop_a);
    }
    if constexpr ((kBodies & kHasPropB) != 0) {
      now.b = motion_of(members.props_b, members.mixed_b, patch.prop_b);
    }
    const V normal_impulse =
        simd::max(solve_normals<kBodies>(now, patch, last), patch.min_normal_impulse);
    V slipping = {};
    if (members.num_anchors > 0) slipping = solve_friction<kBodies>(now, patch, normal_impulse);
    if (members.torsion)
      slipping = simd::max(slipping, solve_torsion<kBodies>(now, patch, normal_impulse));
    patch.slipping = slipping;
    if constexpr ((kBodies & kHasLink) != 0) velocity = now.velocity;
    if constexpr ((kBodies & kHasPropA) != 0) {
      set_velocity(members.props_a, members.mixed_a, patch.prop_a, now.a);
    }
    if constexpr ((kBodies & kHasPropB) != 0) {
      set_velocity(members.props_b, members.mixed_b, patch.prop_b, now.b);
    }
  }

  // The combinations that collision pairs have (see ShapePair); others are solved as if they had
  // all.
  ENGRAM_INLINE void solve_any(PatchLanes<V>& patch, const PatchMembers& members,
                               JointsOf<V>& velocity, bool last) {
    const unsigned bodies = (members.links != 0 ? kHasLink : 0U) |
                            (members.props_a != 0 ? kHasPropA : 0U) |
                            (members.props_b != 0 ? kHasPropB : 0U);
    switch (bodies) {
      case kHasLink:
        return solve_patch<kHasLink>(patch, members, velocity, last);
      case kHasPropA:
        return solve_patch<kHasPropA>(patch, members, velocity, last);
      case kHasLink | kHasPropB:
        return solve_patch<kHasLink | kHasPropB>(patch, members, velocity, last);
      case kHasPropA | kHasPropB:
        return solve_patch<kHasPropA | kHasPropB>(patch, members, velocity, last);
      default:
        return solve_patch<kHasLink | kHasPropA | kHasPropB>(patch, members, velocity, last);
    }
  }
};

}  // namespace ENGRAM_ISA
}  // namespace engram
