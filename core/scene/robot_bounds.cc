#include "core/scene/robot_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/base/index.h"
#include "core/math/eigen_types.h"
#include "core/scene/proximity.h"
#include "core/scene/speculative_margin.h"

namespace engram {
namespace {

// About as far as points of the robot move in three control steps. Larger distances need not be
// known precisely.
constexpr double kMaxSelfClearance = 0.15;  // m

struct Sphere {
  Vec3 center;
  double radius;
};

Vec3 geom_axis(const mjModel& model, int geom) {
  const mjtNum* q = model.geom_quat + 4 * geom;
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * Vec3::UnitZ();
}

// Balls whose convex hull contains a geom, in its body's frame.
void append_spheres(const mjModel& model, int geom, std::vector<Sphere>& spheres) {
  const Vec3 pos(model.geom_pos[3 * geom], model.geom_pos[3 * geom + 1],
                 model.geom_pos[3 * geom + 2]);
  const mjtNum* size = model.geom_size + 3 * geom;
  if (model.geom_type[geom] == mjGEOM_CAPSULE) {
    const Vec3 half = size[1] * geom_axis(model, geom);
    spheres.push_back({pos - half, size[0]});
    spheres.push_back({pos + half, size[0]});
  } else if (model.geom_type[geom] == mjGEOM_BOX) {
    const mjtNum* q = model.geom_quat + 4 * geom;
    const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 local((corner & 1) != 0 ? size[0] : -size[0],
                       (corner & 2) != 0 ? size[1] : -size[1],
                       (corner & 4) != 0 ? size[2] : -size[2]);
      spheres.push_back({pos + rotation * local, 0});
    }
  } else {
    spheres.push_back({pos, model.geom_rbound[geom]});
  }
}

struct Segment {
  Vec3 a;
  Vec3 b;
  double radius;
};

// The capsule along `axis` around all spheres: as thick as it must be, then as short as it can be.
Segment fit_capsule(const std::vector<Sphere>& spheres, const Vec3& axis) {
  Vec3 low = Vec3::Constant(1e9);
  Vec3 high = Vec3::Constant(-1e9);
  for (const Sphere& sphere : spheres) {
    const Vec3 across = sphere.center - axis * axis.dot(sphere.center);
    low = low.cwiseMin((across.array() - sphere.radius).matrix());
    high = high.cwiseMax((across.array() + sphere.radius).matrix());
  }
  const Vec3 middle = 0.5 * (low + high);
  const Vec3 line = middle - axis * axis.dot(middle);
  double radius = 0;
  for (const Sphere& sphere : spheres) {
    const Vec3 across = sphere.center - axis * axis.dot(sphere.center) - line;
    radius = std::max(radius, across.norm() + sphere.radius);
  }
  radius += 1e-9;
  double first = 1e9;
  double last = -1e9;
  for (const Sphere& sphere : spheres) {
    const double along = axis.dot(sphere.center);
    const double across = (sphere.center - axis * along - line).norm();
    const double slack = std::sqrt(
        std::max(0.0, (radius - sphere.radius) * (radius - sphere.radius) - across * across));
    first = std::min(first, along + slack);
    last = std::max(last, along - slack);
  }
  if (first > last) first = last = 0.5 * (first + last);
  return {line + first * axis, line + last * axis, radius};
}

double volume(const Segment& s) { return s.radius * s.radius * ((s.b - s.a).norm() + s.radius); }

double point_segment_squared(const Vec3& point, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double length = along.squaredNorm();
  const double t = length > 0 ? std::clamp((point - a).dot(along) / length, 0.0, 1.0) : 0.0;
  return (point - a - t * along).squaredNorm();
}

// Squared distance of two segments. If the nearest points of their lines lie inside both, it is
// that of the lines; otherwise it is the least distance of an end to the other segment.
double segments_squared(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1) {
  const Vec3 u = a1 - a0;
  const Vec3 v = b1 - b0;
  const Vec3 w = a0 - b0;
  const double uu = u.squaredNorm();
  const double uv = u.dot(v);
  const double vv = v.squaredNorm();
  const double det = uu * vv - uv * uv;
  if (det > 1e-12 * uu * vv) {
    const double s = (uv * v.dot(w) - vv * u.dot(w)) / det;
    const double t = (uu * v.dot(w) - uv * u.dot(w)) / det;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) return (w + s * u - t * v).squaredNorm();
  }
  return std::min(std::min(point_segment_squared(a0, b0, b1), point_segment_squared(a1, b0, b1)),
                  std::min(point_segment_squared(b0, a0, a1), point_segment_squared(b1, a0, a1)));
}

}  // namespace

int RobotBounds::index_of_body(int body) const {
  const auto found = std::find_if(capsules_.begin(), capsules_.end(),
                                  [body](const Capsule& c) { return c.body == body; });
  return found == capsules_.end() ? -1 : static_cast<int>(found - capsules_.begin());
}

void RobotBounds::add_capsule(const mjModel& robot, int body) {
  std::vector<Sphere> spheres;
  std::vector<Vec3> axes = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  const int first = robot.body_geomadr[body];
  for (int geom = first; geom < first + robot.body_geomnum[body]; ++geom) {
    append_spheres(robot, geom, spheres);
    axes.push_back(geom_axis(robot, geom));
  }
  if (spheres.empty()) return;
  Segment best = fit_capsule(spheres, axes.front());
  for (const Vec3& axis : axes) {
    const Segment segment = fit_capsule(spheres, axis);
    if (volume(segment) < volume(best)) best = segment;
  }
  const double bounding_radius = 0.5 * (best.b - best.a).norm() + best.radius;
  const Attachment fixed = attachment_of(robot, body);
  const auto in_link = [&](const Vec3& point) {
    return Vec3(fixed.frame.pos + fixed.frame.axes * point);
  };
  capsules_.push_back({body, fixed.link, in_link(best.a), in_link(best.b), best.radius,
                       bounding_radius, false, false});
}

RobotBounds::RobotBounds(const mjModel& robot, const mjModel& whole) {
  for (int body = 1; body < robot.nbody; ++body) add_capsule(robot, body);
  if (capsules_.size() > kMaxBodies) {
    throw Error(Error::kInternal,
                "robot of more than " + std::to_string(kMaxBodies) + " bodies with geometry");
  }
  find_lever_arms(robot);
  for (int pair = 0; pair < whole.npair; ++pair) {
    const int body1 = whole.geom_bodyid[whole.pair_geom1[pair]];
    const int body2 = whole.geom_bodyid[whole.pair_geom2[pair]];
    // In the whole scene, bodies after the robot's are props. Body 0 has the table top.
    const int first = body1 > 0 && body1 < robot.nbody ? index_of_body(body1) : -1;
    const int second = body2 > 0 && body2 < robot.nbody ? index_of_body(body2) : -1;
    if (first >= 0 && second >= 0) {
      pairs_.push_back(pair_of(first, second));
    } else if (first >= 0 || second >= 0) {
      Capsule& capsule = capsules_[at(std::max(first, second))];
      const int other = first >= 0 ? body2 : body1;
      (other == 0 ? capsule.meets_table : capsule.meets_props) = true;
    }
  }
  std::sort(pairs_.begin(), pairs_.end());
  pairs_.erase(std::unique(pairs_.begin(), pairs_.end()), pairs_.end());
}

// Bodies of a chain: joints up to the first body move both. A finger's joint moves no other body,
// so that both fingers' joints count for pairs with one.
RobotBounds::Pair RobotBounds::pair_of(int capsule, int other) const {
  const int link = std::min(capsules_[at(capsule)].link, capsules_[at(other)].link);
  return {std::min(capsule, other), std::max(capsule, other), std::min(link + 1, kArmJoints)};
}

// A joint's lever arm is the largest distance of a point of its body, or of what the body carries,
// from the body's origin.
void RobotBounds::find_lever_arms(const mjModel& robot) {
  const int num_bodies = static_cast<int>(robot.nbody);
  std::vector<double> extent(at(num_bodies), 0.0);
  for (const Capsule& capsule : capsules_) {
    const int link = capsule.link < 0 ? 0 : robot.jnt_bodyid[capsule.link];
    double& reach = extent[at(link)];
    reach = std::max(reach, std::max(capsule.a.norm(), capsule.b.norm()) + capsule.radius);
  }
  for (int body = num_bodies - 1; body > 0; --body) {  // children come after their parents
    double offset = Eigen::Map<const Vec3>(robot.body_pos + 3 * body).norm();
    for (int k = 0; k < robot.body_jntnum[body]; ++k) {
      const int joint = robot.body_jntadr[body] + k;
      if (robot.jnt_type[joint] != mjJNT_SLIDE) continue;
      const double* range = robot.jnt_range + 2 * joint;
      offset += std::max(std::abs(range[0]), std::abs(range[1]));
    }
    double& parent = extent[at(robot.body_parentid[body])];
    parent = std::max(parent, offset + extent[at(body)]);
  }
  for (int joint = 0; joint < kRobotJoints; ++joint) {
    const double anchor = Eigen::Map<const Vec3>(robot.jnt_pos + 3 * joint).norm();
    const bool slides = robot.jnt_type[joint] == mjJNT_SLIDE;
    lever_arms_[at(joint)] = slides ? 1.0 : anchor + extent[at(robot.jnt_bodyid[joint])];
  }
}

RobotBounds::Clearance RobotBounds::clearance(const RobotPose& pose,
                                              std::span<const Obstacle> obstacles) const {
  CapsulePositions positions;
  Clearance result;
  double table = kFarAway;
  double lowest = kFarAway;  // of the capsules that can meet props
  for (std::size_t i = 0; i < capsules_.size(); ++i) {
    const Capsule& capsule = capsules_[i];
    positions.a[i] = capsule.a;
    positions.b[i] = capsule.b;
    if (capsule.link >= 0) {
      const Frame& link = pose.links[at(capsule.link)];
      positions.a[i] = link.pos + link.axes * capsule.a;
      positions.b[i] = link.pos + link.axes * capsule.b;
    }
    positions.middle[i] = 0.5 * (positions.a[i] + positions.b[i]);
    const double low = std::min(positions.a[i].z(), positions.b[i].z()) - capsule.radius;
    if (capsule.meets_table) table = std::min(table, low);
    if (capsule.meets_props) lowest = std::min(lowest, low);
  }
  table -= kContactMargin;
  if (table <= 0) return result;
  result.self = self_clearance(positions);
  if (*std::min_element(result.self.begin(), result.self.end()) <= 0) return result;
  result.table = table;
  result.obstacles = obstacle_clearance(positions, obstacles, lowest);
  result.lowest = lowest;
  result.qpos = pose.qpos;
  return result;
}

JointArray RobotBounds::self_clearance(const CapsulePositions& positions) const {
  JointArray result;
  result.fill(kMaxSelfClearance);
  for (const Pair& pair : pairs_) {
    const auto i = at(pair.first);
    const auto j = at(pair.second);
    double& least = result[at(pair.joint)];
    // Most pairs are so far apart that the spheres around the capsules show it.
    const double apart =
        capsules_[i].bounding_radius + capsules_[j].bounding_radius + least + kSelfMargin;
    if ((positions.middle[i] - positions.middle[j]).squaredNorm() > apart * apart) continue;
    const double squared =
        segments_squared(positions.a[i], positions.b[i], positions.a[j], positions.b[j]);
    least = std::min(least,
                     std::sqrt(squared) - capsules_[i].radius - capsules_[j].radius - kSelfMargin);
    if (least <= 0) break;
  }
  return result;
}

double RobotBounds::obstacle_clearance(const CapsulePositions& positions,
                                       std::span<const Obstacle> obstacles, double lowest) const {
  double least = kFarAway;
  for (const Obstacle& obstacle : obstacles) {
    const double below = lowest - obstacle.center.z() - obstacle.radius;
    if (below > 0) {
      least = std::min(least, below);
      continue;
    }
    for (std::size_t i = 0; i < capsules_.size(); ++i) {
      if (!capsules_[i].meets_props) continue;
      const double squared = point_segment_squared(obstacle.center, positions.a[i], positions.b[i]);
      least = std::min(least, std::sqrt(squared) - capsules_[i].radius - obstacle.radius);
    }
    if (least <= 0) break;
  }
  return least;
}

RobotBounds::Clearance RobotBounds::with_obstacles(const Clearance& before,
                                                   std::span<const Obstacle> obstacles) {
  Clearance result = before;
  result.obstacles = kFarAway;
  for (const Obstacle& obstacle : obstacles) {
    const double below = before.lowest - obstacle.center.z() - obstacle.radius;
    result.obstacles = std::min(result.obstacles, below);
  }
  return result;
}

double RobotBounds::max_displacement(const JointArray& from, const JointArray& to) const {
  double displacement = 0;
  for (std::size_t joint = 0; joint < lever_arms_.size(); ++joint) {
    displacement += lever_arms_[joint] * std::abs(to[joint] - from[joint]);
  }
  return displacement;
}

}  // namespace engram
