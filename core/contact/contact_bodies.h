// Bodies of contacts in the solver's lanes: free bodies and the robot's links, and how far they
// have moved since the substep began.
#pragma once

#include "core/contact/contact_lanes.h"
#include "core/robot/link_frames.h"

namespace engram {
inline namespace ENGRAM_ISA {

template <class V>
class ContactBodies {
 public:
  // `joints` after its prepare(); `frames` and `velocity` at the substep's start.
  ContactBodies(const ContactLanes& lanes, const LinkFrames<V>& frames,
                const JointSolver<V>& joints, float timestep)
      : lanes_(lanes),
        bodies_(reinterpret_cast<FreeBodyLanes<V>*>(lanes.bodies)),
        patches_(reinterpret_cast<PatchLanes<V>*>(lanes.patches)),
        frames_(frames),
        inv_mass_(joints.inv_mass),
        timestep_(timestep),
        dt_(timestep / kSolverIterations) {
    prepare_links(joints.begin_v);
  }

  void move_bodies() {
    for (int i = 0; i < lanes_.num_bodies; ++i) {
      FreeBodyLanes<V>& body = bodies_[i];
      body.delta_position = body.delta_position + body.linear * simd::broadcast<V>(dt_);
      body.delta_rotation = body.delta_rotation + body.angular * simd::broadcast<V>(dt_);
      rotate(body);
    }
  }

  // Displacements of joints, and those of the links' centres of mass beyond their Jacobians, to
  // second order.
  void move_links(const WideRow<V>& displacement) {
    time_ += dt_;
    if (links_ == 0) return;
    displacement.store(delta_q_);
    update_second_order();
  }

 protected:
  struct Motion {
    Vec3Of<V> linear, angular, delta_position, delta_rotation;
  };
  using Vec = Vec3Of<V>;

  template <class Visit>
  ENGRAM_INLINE void for_each_patch(int list, const Visit& visit) {
    const int begin = lanes_.lists.begin[list];
    for (int i = begin; i < begin + lanes_.lists.size[list]; ++i) {
      visit(patches_[i], lanes_.members[i]);
    }
  }

  // --- free bodies ---

  // Value of a lane's own body; zeros if it has none.
  template <class Get>
  ENGRAM_INLINE auto gather(unsigned long long props, bool mixed, V body_index,
                            const Get& get) const {
    int first = 0;
    while ((props >> first & 1U) == 0) ++first;
    auto value = get(bodies_[first]);
    if (!mixed) return value;
    value = decltype(value)();
    for (int i = first; props >> i != 0; ++i) {
      if ((props >> i & 1U) == 0) continue;
      const auto other = get(bodies_[i]);
      const auto mine = body_index == static_cast<float>(i);
      for (int k = 0; k < kWords<decltype(value)>; ++k) {
        word(value, k) = mine ? word(other, k) : word(value, k);
      }
    }
    return value;
  }
  template <class T>
  static constexpr int kWords = static_cast<int>(sizeof(T) / sizeof(V));
  template <class T>
  ENGRAM_INLINE static V& word(T& value, int k) {
    return reinterpret_cast<V*>(&value)[k];
  }
  template <class T>
  ENGRAM_INLINE static const V& word(const T& value, int k) {
    return reinterpret_cast<const V*>(&value)[k];
  }

  ENGRAM_INLINE Motion motion_of(unsigned long long props, bool mixed, V body_index) const {
    return gather(props, mixed, body_index, [](const FreeBodyLanes<V>& body) {
      return Motion{body.linear, body.angular, body.delta_position, body.delta_rotation};
    });
  }
  ENGRAM_INLINE void set_velocity(unsigned long long props, bool mixed, V body_index,
                                  const Motion& motion) {
    for (int i = 0; props >> i != 0; ++i) {
      if ((props >> i & 1U) == 0) continue;
      FreeBodyLanes<V>& body = bodies_[i];
      if (!mixed) {
        body.linear = motion.linear;
        body.angular = motion.angular;
        continue;
      }
      const auto mine = body_index == static_cast<float>(i);
      for (int k = 0; k < 3; ++k) {
        body.linear[k] = mine ? motion.linear[k] : body.linear[k];
        body.angular[k] = mine ? motion.angular[k] : body.angular[k];
      }
    }
  }

  struct Inertia {
    V inv_mass;
    V at[6];
  };
  ENGRAM_INLINE Inertia inertia_of_body(unsigned long long props, bool mixed, V body_index) const {
    if (props == 0) return Inertia();
    return gather(props, mixed, body_index, [](const FreeBodyLanes<V>& body) {
      Inertia result;
      result.inv_mass = body.inv_mass;
      for (int k = 0; k < 6; ++k) result.at[k] = body.inv_inertia[k];
      return result;
    });
  }
  ENGRAM_INLINE static Vec response(const Inertia& inertia, const Vec& turn) {
    const V* i = inertia.at;
    return {i[0] * turn.x() + i[3] * turn.y() + i[4] * turn.z(),
            i[3] * turn.x() + i[1] * turn.y() + i[5] * turn.z(),
            i[4] * turn.x() + i[5] * turn.y() + i[2] * turn.z()};
  }

  // Exponential map of one iteration's turn.
  ENGRAM_INLINE void rotate(FreeBodyLanes<V>& body) {
    const V speed = simd::sqrt(dot(body.angular, body.angular));
    V sine;
    V cosine;
    sine_cosine(speed * (0.5F * dt_), sine, cosine);
    const V scale = speed > 0.0F ? sine / speed : V{};
    const Vec v = body.angular * scale;
    const QuatOf<V> q = body.rotation;
    body.rotation = {cosine * q.w - (v.x() * q.x + v.y() * q.y + v.z() * q.z),
                     cosine * q.x + q.w * v.x() + (v.y() * q.z - v.z() * q.y),
                     cosine * q.y + q.w * v.y() + (v.z() * q.x - v.x() * q.z),
                     cosine * q.z + q.w * v.z() + (v.x() * q.y - v.y() * q.x)};
  }

  // --- links ---

  void prepare_links(const JointsOf<V>& velocity) {
    for (int list = 0; list < PatchLists::kCount; ++list) {
      for_each_patch(list, [&](const PatchLanes<V>& /*patch*/, const PatchMembers& members) {
        links_ |= members.links;
      });
    }
    for (int link = 0; link < kNumLinks; ++link) {
      if ((links_ >> link & 1U) == 0) continue;
      compliance_[link] = frames_.compliance(link, inv_mass_);
      JointsOf<V> rows[3];
      frames_.center_jacobian(link, rows);
      for (int i = 0; i < kRobotJoints; ++i)
        column_[link][i] = {rows[0][i], rows[1][i], rows[2][i]};
      second_order_displacement_[link] = {};
      center_[link] = frames_.center(link);
      frames_.bias_acceleration(link, velocity, added_linear_[link], added_angular_[link]);
      added_linear_[link] = added_linear_[link] * simd::broadcast<V>(timestep_);
      added_angular_[link] = added_angular_[link] * simd::broadcast<V>(timestep_);
    }
  }

  // Motion on a hinge's circle beyond its tangent, by the turns of that hinge and those before it.
  void update_second_order() {
    Vec delta_rotation = {};
    Vec lever[kArmJoints];
    for (int i = 0; i < kArmJoints; ++i) {
      const Vec turn = frames_.axis(i) * delta_q_[i];
      lever[i] = (delta_rotation + turn * simd::broadcast<V>(0.5F)) * delta_q_[i];
      delta_rotation = delta_rotation + turn;
    }
    for (int link = 0; link < kNumLinks; ++link) {
      if ((links_ >> link & 1U) == 0) continue;
      Vec second_order = {};
      for (int i = 0; i < hinges_of(link); ++i)
        second_order = second_order + cross(lever[i], column_[link][i]);
      const int finger = finger_of(link);
      if (finger >= 0) {
        const int joint = kArmJoints + finger;
        second_order = second_order + cross(delta_rotation, column_[link][joint] * delta_q_[joint]);
      }
      second_order_displacement_[link] = second_order;
    }
  }

  // Sum over A's link, less B's, of a quantity of links.
  template <class T>
  ENGRAM_INLINE Vec link_difference(const PatchLanes<V>& patch, const PatchMembers& members,
                                    const T& of_link) const {
    // A single link is A.
    if (!members.mixed_links && (members.links & (members.links - 1)) == 0) {
      return members.links == 0 ? Vec{} : of_link(__builtin_ctz(members.links));
    }
    Vec sum = {};
    for (int link = 0; link < kNumLinks; ++link) {
      if ((members.links >> link & 1U) == 0) continue;
      const Vec value = of_link(link);
      const auto is_a = patch.link_a == static_cast<float>(link);
      const auto is_b = patch.link_b == static_cast<float>(link);
      for (int k = 0; k < 3; ++k) {
        sum[k] += (is_a ? value[k] : V{}) - (is_b ? value[k] : V{});
      }
    }
    return sum;
  }

  // Velocities that bias accelerations add, of A's link less B's: of centres of mass, of a point
  // around them, and angular ones.
  ENGRAM_INLINE Vec added_linear(const PatchLanes<V>& patch, const PatchMembers& members) const {
    return link_difference(patch, members, [&](int link) { return added_linear_[link]; });
  }
  ENGRAM_INLINE Vec added_turn(const PatchLanes<V>& patch, const PatchMembers& members,
                               const Vec& point) const {
    return link_difference(patch, members, [&](int link) {
      return cross(added_angular_[link], point - center_[link]);
    });
  }
  ENGRAM_INLINE Vec added_angular(const PatchLanes<V>& patch, const PatchMembers& members) const {
    return link_difference(patch, members, [&](int link) { return added_angular_[link]; });
  }

  const ContactLanes& lanes_;
  FreeBodyLanes<V>* bodies_;
  PatchLanes<V>* patches_;
  const LinkFrames<V>& frames_;
  const JointMatrixOf<V>& inv_mass_;
  float timestep_;
  float dt_;
  float time_ = 0;  // since the substep's start
  unsigned links_ = 0;
  V compliance_[kNumLinks];
  Vec column_[kNumLinks][kRobotJoints];
  Vec second_order_displacement_[kNumLinks];
  // What the bias acceleration adds to a link's velocity in the substep.
  Vec center_[kNumLinks], added_linear_[kNumLinks], added_angular_[kNumLinks];
  JointsOf<V> delta_q_;
};

}  // namespace ENGRAM_ISA
}  // namespace engram
