#include "core/collision/broad_phase.h"

#include <algorithm>
#include <limits>

#include "core/collision/narrow_phase.h"

namespace engram {
namespace {

// What acceleration may add to a body's speed in a substep, besides kSpeculativeFactor.
constexpr double kSpeedGain = 0.15;  // m/s

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

void copy(const Vec3& from, double* to) { std::copy_n(from.data(), 3, to); }

bool moves_freely(const CollisionBody& body) {
  return body.kind == BodyKind::kLink || body.kind == BodyKind::kFree;
}

}  // namespace

// The original orders a ball's contacts with the fingers from where they may first exist. While a
// free ball is awake, no clearance leaves the search out.
double near_gap_of(const CollisionScene& scene, const ShapePair& pair) {
  const CollisionShape& a = scene.shapes()[at(pair.a)];
  const CollisionShape& b = scene.shapes()[at(pair.b)];
  const bool of_finger = finger_of(scene.bodies()[at(a.body)].link) >= 0;
  const bool of_ball =
      b.type == mjGEOM_SPHERE && scene.bodies()[at(b.body)].kind == BodyKind::kFree;
  return a.type == mjGEOM_BOX && of_finger && of_ball ? kContactReach : kActiveGap;
}

BroadPhase::BroadPhase(const CollisionScene& scene, double timestep, int lanes)
    : lanes_(lanes), present_(scene.bodies().size()), near_(scene.shape_pairs().size()) {
  int num_frames = kRobotJoints;
  for (const CollisionBody& from : scene.bodies()) {
    BroadPhaseLanes::Body& body = body_models_.emplace_back();
    body.link = from.link;
    // A body that no prop or link is stands still.
    body.frame = from.link >= 0 ? from.attachment.link : from.prop >= 0 ? num_frames++ : -1;
    copy(from.attachment.frame.pos + from.attachment.frame.axes * from.bounding_center,
         body.center);
    body.radius = from.bounding_radius;
    body.speed_gain = moves_freely(from) ? kSpeedGain : 0;
  }
  for (const CollisionShape& from : scene.shapes()) {
    BroadPhaseLanes::Shape& shape = shape_models_.emplace_back();
    const Frame& carrier = scene.bodies()[at(from.body)].attachment.frame;
    shape.frame = body_models_[at(from.body)].frame;
    shape.is_box = from.is_box();
    copy(carrier.pos + carrier.axes * from.frame.pos, shape.pos);
    Eigen::Map<RowMat3>{shape.axes} = carrier.axes * from.frame.axes;
    copy(from.half, shape.half);
    shape.radius = from.bounding_radius;
  }
  for (const ShapePair& pair : scene.shape_pairs()) {
    const auto of_robot = [&](int shape) {
      return scene.bodies()[at(scene.shapes()[at(shape)].body)].of_robot;
    };
    const bool self = of_robot(pair.a) && of_robot(pair.b);
    shape_pairs_.push_back(
        {pair.a, pair.b, near_gap_of(scene, pair), self ? kMaxSelfGap : kUnlimited});
  }
  for (const BodyPair& pair : scene.body_pairs()) {
    const CollisionBody& b = scene.bodies()[at(pair.b)];
    const bool one_box = b.num_shapes == 1 && scene.shapes()[at(b.first_shape)].is_box();
    const auto first = shape_pairs_.begin() + pair.first;
    const auto gap = std::max_element(first, first + pair.count, [](const auto& x, const auto& y) {
      return x.near_gap < y.near_gap;
    });
    body_pairs_.push_back(
        {pair.a, pair.b, pair.first, pair.count, one_box ? b.first_shape : -1, gap->near_gap});
  }
  const auto rows = [lanes](std::size_t count, int each) {
    return AlignedArray<double>(count * at(each * lanes));
  };
  frames_ = rows(at(num_frames), BroadPhaseLanes::kFrameRows);
  bodies_ = rows(body_models_.size(), BroadPhaseLanes::kBodyRows);
  shapes_ = rows(shape_models_.size(), BroadPhaseLanes::kFrameRows);
  is_posed_ = AlignedArray<bool>(shape_models_.size());
  put_static();
  view_ = {body_models_.data(),
           static_cast<int>(body_models_.size()),
           shape_models_.data(),
           static_cast<int>(shape_models_.size()),
           shape_pairs_.data(),
           body_pairs_.data(),
           static_cast<int>(body_pairs_.size()),
           timestep,
           frames_.data(),
           bodies_.data(),
           shapes_.data(),
           is_posed_.data(),
           present_.data(),
           near_.data(),
           0};
}

void BroadPhase::put_static() {
  for (std::size_t i = 0; i < shape_models_.size(); ++i) {
    const BroadPhaseLanes::Shape& shape = shape_models_[i];
    if (shape.frame >= 0) continue;
    const Frame frame = {Eigen::Map<const Vec3>(shape.pos), Eigen::Map<const RowMat3>(shape.axes)};
    for (int lane = 0; lane < lanes_; ++lane) {
      put_frame(shapes_, static_cast<int>(i), lane, frame);
    }
  }
  for (std::size_t i = 0; i < body_models_.size(); ++i) {
    if (body_models_[i].frame >= 0) continue;
    const int first = BroadPhaseLanes::kBodyRows * static_cast<int>(i) + BroadPhaseLanes::kCenter;
    for (int lane = 0; lane < lanes_; ++lane) {
      put_rows(bodies_, first, lane, body_models_[i].center, 3);
    }
  }
}

void BroadPhase::clear() {
  std::fill(present_.begin(), present_.end(), 0U);
  view_.num_near = 0;
}

void BroadPhase::enter(int lane, const std::vector<BodyPresence>& presence) {
  for (std::size_t i = 0; i < presence.size(); ++i) {
    present_[i] |= (presence[i] == BodyPresence::kPresent ? 1U : 0U) << lane;
  }
}

void BroadPhase::put(int lane, int body, const Frame& frame, double speed) {
  put_frame(frames_, body_models_[at(body)].frame, lane, frame);
  put_rows(bodies_, BroadPhaseLanes::kBodyRows * body + BroadPhaseLanes::kSpeed, lane, &speed, 1);
}

double BroadPhase::fastest_link(int lane) const {
  double fastest = 0;
  for (std::size_t i = 0; i < body_models_.size(); ++i) {
    if (body_models_[i].link >= 0) fastest = std::max(fastest, speed(lane, static_cast<int>(i)));
  }
  return fastest;
}

void BroadPhase::put_rows(AlignedArray<double>& rows, int first, int lane, const double* values,
                          int count) {
  for (int i = 0; i < count; ++i) rows[at((first + i) * lanes_ + lane)] = values[i];
}

void BroadPhase::put_frame(AlignedArray<double>& rows, int index, int lane, const Frame& frame) {
  const int first = BroadPhaseLanes::kFrameRows * index;
  put_rows(rows, first, lane, frame.pos.data(), 3);
  const RowMat3 axes = frame.axes;
  put_rows(rows, first + 3, lane, axes.data(), 9);
}

}  // namespace engram
