// The contact law by itself: every substep begins at the original's state, with the original's
// contact points, and ends where the original's did.
#include "core/contact/contact_solver.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "core/contact/contact_kernel.h"
#include "core/contact/friction_patch.h"
#include "core/robot/lane_block.h"
#include "core/scene/physics_model.h"
#include "tasks/common/task_info.h"
#include "tests/core/contact/recorded_contacts.h"

namespace engram {
namespace {

using test::RecordedBody, test::RecordedPoint, test::RecordedRobot, test::RecordedRun,
    test::RecordedSubstep, test::Recordings;

// Errors of one substep.
struct Errors {
  double pos = 0;      // um
  double impulse = 0;  // of the sum of all impulses, %
  double joints = 0;   // urad
  double fingers = 0;  // um
};

// A pair of shapes, named as in the recording.
using PairName = std::tuple<std::string, std::string, std::string>;

class Law {
 public:
  explicit Law(const RecordedRun& run)
      : model_(tasks::scene_source({.props = test::recorded_props(run)})),
        lanes_(*lane_kernel(1)),
        block_(1, static_cast<int>(model_.props().size()), model_.collision().num_free_shapes(),
               Eigen::Map<const Vec3>(model_.robot_model().base_position)) {}

  // Errors of one substep against the next row of the recording.
  Errors step(const RecordedSubstep& from, const RecordedSubstep& to, bool forget) {
    if (forget) memory_.clear();
    put_robot(from);
    block_.clear();
    put_bodies(from);
    add_patches(from);
    contact_kernel(1).substep(model_.robot_model(), model_.robot_params(), false, lanes_.vectors(),
                              block_.view());
    read_back();
    return compare(to);
  }

 private:
  struct Patch {
    PairName pair;
    int patch = 0;
    int index = 0;
    Vec3 normal;
  };

  static JointArray parked() { return {0, 0, 0, -1.9, 0, 2.6, 0.8, 0.04, 0.04}; }

  void put_robot(const RecordedSubstep& from) {
    RecordedRobot robot{parked(), {}, parked()};
    if (!from.robot.empty()) robot = from.robot.front();
    lanes_.put(LaneVectors::kQ, 0, robot.qpos.data(), kRobotJoints);
    lanes_.put(LaneVectors::kV, 0, robot.qvel.data(), kRobotJoints);
    JointArray bias{};
    for (std::size_t i = 0; i < kRobotJoints; ++i) {
      bias[i] = model_.robot_params().drive.stiffness * robot.target[i];
    }
    lanes_.put(LaneVectors::kDriveBias, 0, bias.data(), kRobotJoints);
    pose_ = pose_at(model_.robot_model(), robot.qpos.data());
  }

  void put_bodies(const RecordedSubstep& from) {
    bodies_.clear();
    for (const RecordedBody& body : from.bodies) {
      FreeBodyState state{body.pos, body.quat, body.linear, body.angular};
      before_[body.name] = {state.center, state.quat.toRotationMatrix()};
      const int slot = static_cast<int>(bodies_.size());
      model_.props()[bodies_.size()].body.accelerate(state, model_.gravity(), 0.01);
      block_.put_body(0, slot, model_.props()[bodies_.size()].body, state);
      slots_[body.name] = slot;
      bodies_.push_back(state);
    }
  }

  static int link_of(const std::string& body) {
    if (body == "leftfinger") return kLeftFingerLink;
    if (body == "rightfinger") return kRightFingerLink;
    if (body == "hand") return kHandLink;
    return body.starts_with("link") ? body.back() - '1' : -1;
  }

  // Pose of the centre of mass.
  Frame frame_of(const std::string& body) const {
    const auto found = before_.find(body);
    if (found != before_.end()) return found->second;
    const int link = link_of(body);
    if (link < 0) return {};
    const int id = mj_name2id(&model_.robot(), mjOBJ_BODY, body.c_str());
    const Frame frame = carried(pose_, attachment_of(model_.robot(), id));
    return {frame.pos + frame.axes * Eigen::Map<const Vec3>(model_.robot().body_ipos + 3 * id),
            frame.axes};
  }

  void add_patches(const RecordedSubstep& from) {
    std::map<std::tuple<bool, int, int, PairName>, ContactPoints> pairs;  // in order of solving
    reference_.clear();
    for (const RecordedPoint& point : from.points) {
      if (link_of(point.a) < 0 && !before_.contains(point.a))
        continue;  // its motion is not recorded
      const PairName name = {point.a, point.shape, point.b};
      const int finger = point.a == "leftfinger" ? 0 : (point.a == "rightfinger" ? 1 : 2);
      const int shape = point.shape.empty() ? 0 : -std::stoi(point.shape);
      pairs[{point.b == "table", finger, shape, name}].push({point.pos, point.normal, point.gap});
      reference_[name] += point.impulse;
    }
    patches_.clear();
    std::map<PairName, ContactPair> memory;
    for (const auto& [key, points] : pairs) {
      const PairName& name = std::get<3>(key);
      ContactPair& pair = memory[name] = memory_[name];
      add_pair(name, points, pair);
    }
    memory_ = std::move(memory);
  }

  void add_pair(const PairName& name, const ContactPoints& points, ContactPair& pair) {
    const auto& [a, shape, b] = name;
    const bool rubber = link_of(a) >= 0 && finger_of(link_of(a)) >= 0;
    std::array<PatchSpec, ContactPair::kMaxPatches> specs;
    const int count = build_patches(points, frame_of(a), frame_of(b), pair, specs);
    for (int i = 0; i < count; ++i) {
      PatchSpec& spec = specs[static_cast<std::size_t>(i)];
      spec.link_a = link_of(a);
      spec.body_a = spec.link_a >= 0 ? -1 : slots_.at(a);
      spec.body_b = b == "table" ? -1 : slots_.at(b);
      spec.friction = rubber ? 1.15 : 0.3;
      spec.torsion_radius = rubber ? 0.1 : 0;
      spec.list = b != "table"      ? PatchLists::kMoving
                  : spec.link_a < 0 ? PatchLists::kFixed
                  : rubber          ? PatchLists::kLinks + spec.link_a
                                    : PatchLists::kLinks + kArmJoints - 1;
      const int patch = block_.add_patch(0, spec);
      REQUIRE(patch >= 0);
      patches_.push_back({name, patch, i, spec.normal});
    }
  }

  void read_back() {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      block_.get_body(0, static_cast<int>(i), bodies_[i]);
    }
    impulse_.clear();
    for (std::size_t i = patches_.size(); i-- > 0;) {
      const Patch& patch = patches_[i];
      impulse_[patch.pair] += block_.impulse(0, patch.patch).dot(patch.normal);
      if (!block_.is_slipping(0, patch.patch)) continue;
      ContactPair& pair = memory_[patch.pair];
      std::copy(pair.patches.begin() + patch.index + 1, pair.patches.begin() + pair.num_patches,
                pair.patches.begin() + patch.index);
      --pair.num_patches;
    }
  }

  Errors compare(const RecordedSubstep& to) const {
    Errors errors;
    for (const RecordedBody& body : to.bodies) {
      const FreeBodyState& state = bodies_[static_cast<std::size_t>(slots_.at(body.name))];
      errors.pos = std::max(errors.pos, 1e6 * (state.center - body.pos).norm());
    }
    for (const RecordedRobot& robot : to.robot) {
      JointArray q;
      lanes_.get(LaneVectors::kEndQ, 0, q.data(), kRobotJoints);
      for (std::size_t i = 0; i < kRobotJoints; ++i) {
        double& error = i < kArmJoints ? errors.joints : errors.fingers;
        error = std::max(error, 1e6 * std::abs(q[i] - robot.qpos[i]));
      }
    }
    double total = 0;
    double apart = 0;
    for (const auto& [name, impulse] : reference_) {
      total += impulse;
      const auto mine = impulse_.find(name);
      apart += std::abs(impulse - (mine == impulse_.end() ? 0 : mine->second));
    }
    errors.impulse = total > 0 ? 100 * apart / total : 0;
    return errors;
  }

  PhysicsModel model_;
  LaneBlock lanes_;
  ContactBlock block_;
  RobotPose pose_;
  std::map<std::string, Frame> before_;
  std::map<std::string, int> slots_;
  std::vector<FreeBodyState> bodies_;
  std::map<PairName, ContactPair> memory_;
  std::map<PairName, double> reference_;
  std::map<PairName, double> impulse_;
  std::vector<Patch> patches_;
};

double percentile90(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() * 9 / 10];
}

// The largest errors of nine substeps in ten.
Errors worst_of(const std::string& name, const RecordedRun& run) {
  Law law(run);
  std::vector<double> pos, impulse, joints, fingers;
  int substeps = 0;
  for (const auto& [substep, from] : run) {
    const auto to = run.find(substep + 1);
    if (to == run.end() || from.points.empty()) continue;
    const Errors errors = law.step(from, to->second, test::sets_poses(name) && substep % 5 == 0);
    pos.push_back(errors.pos);
    impulse.push_back(errors.impulse);
    joints.push_back(errors.joints);
    fingers.push_back(errors.fingers);
    ++substeps;
  }
  if (substeps < 10) return {-1, 0, 0, 0};
  return {percentile90(pos), percentile90(impulse), percentile90(joints), percentile90(fingers)};
}

TEST_CASE("From the original's contacts follow its impulses and its motion",
          "[physics][original]") {
  int runs = 0;
  for (const auto& [name, run] : Recordings::runs()) {
    if (name.starts_with("battery")) continue;
    const Errors worst = worst_of(name, run);
    if (worst.pos < 0) continue;  // recorded by control steps only
    ++runs;
    INFO(name << ": " << worst.pos << " um, impulses " << worst.impulse << " %, joints "
              << worst.joints << " urad, fingers " << worst.fingers << " um");
    CHECK(worst.impulse < 0.5);
    CHECK(worst.pos < 1.5);
    CHECK(worst.joints < 2);
    CHECK(worst.fingers < (name.starts_with("press") ? 0.5 : 0.1));
  }
  CHECK(runs == 10);
}

}  // namespace
}  // namespace engram
