#include "core/contact/friction_patch.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

namespace engram {
namespace {

constexpr double kHalf = 0.02;  // m, of a cube on the table

Frame cube_at(const Vec3& offset, double degrees = 0, const Vec3& axis = Vec3::UnitZ()) {
  const double angle = degrees * std::numbers::pi / 180;
  return {Vec3(0, 0, kHalf) + offset, Eigen::AngleAxisd(angle, axis).toRotationMatrix()};
}
const Frame kTable;

ContactPoints points_at(const std::vector<Vec3>& positions, double gap = 0,
                        const Vec3& normal = Vec3::UnitZ()) {
  ContactPoints points;
  for (const Vec3& pos : positions) points.push({pos, normal, gap});
  return points;
}
// Lower corners of the cube at the origin.
ContactPoints corners(double gap = 0) {
  return points_at({{kHalf, kHalf, 0}, {kHalf, -kHalf, 0}, {-kHalf, -kHalf, 0}, {-kHalf, kHalf, 0}},
                   gap);
}

// A pair whose patches are built again and again.
class Pair {
 public:
  int build(const ContactPoints& points, const Frame& cube = cube_at(Vec3::Zero())) {
    return build_patches(points, cube, kTable, pair_, specs_);
  }
  const PatchSpec& spec(std::size_t i = 0) const { return specs_[i]; }
  const ContactPair& memory() const { return pair_; }
  // Largest distance of an anchor on the cube from its anchor on the table.
  double stretch() const {
    double most = 0;
    for (int i = 0; i < spec().num_anchors; ++i) {
      const auto k = static_cast<std::size_t>(i);
      most = std::max(most, (spec().anchors_a[k] - spec().anchors_b[k]).norm());
    }
    return most;
  }

 private:
  ContactPair pair_;
  std::array<PatchSpec, ContactPair::kMaxPatches> specs_;
};

TEST_CASE("Points of one normal make one patch with two anchors far apart", "[contact]") {
  Pair pair;
  REQUIRE(pair.build(corners(-0.0001)) == 1);
  const PatchSpec& patch = pair.spec();
  CHECK(patch.num_points == 4);
  CHECK(patch.normal == Vec3::UnitZ());
  CHECK(patch.gaps[3] == -0.0001);
  CHECK(patch.points[1].isApprox(Vec3(kHalf, -kHalf, 0)));
  REQUIRE(patch.num_anchors == 2);
  CHECK((patch.anchors_a[0] - patch.anchors_a[1]).norm() == Approx(2 * kHalf * std::sqrt(2.0)));
  CHECK(pair.stretch() < 1e-15);
  CHECK(pair.memory().num_patches == 1);
}

TEST_CASE("Anchors stay where they are while the cube is pushed aside", "[contact]") {
  Pair pair;
  pair.build(corners());
  pair.build(corners(), cube_at({0.0003, 0, 0}));
  CHECK(pair.spec().num_anchors == 2);
  CHECK(pair.stretch() == Approx(0.0003));
  CHECK(pair.spec().anchors_b[0].isApprox(Vec3(kHalf, kHalf, 0)));
  pair.build(corners(), cube_at({0.0007, 0, 0}));
  CHECK(pair.stretch() == Approx(0.0007));
}

TEST_CASE("Anchors are dropped when the bodies part, and taken from the new points", "[contact]") {
  Pair pair;
  pair.build(corners());
  pair.build(corners(0.0024), cube_at({0.0003, 0, 0.0024}));
  CHECK(pair.stretch() > 0.002);  // still the old ones
  pair.build(corners(0.0026), cube_at({0.0003, 0, 0.0026}));
  CHECK(pair.spec().num_anchors == 2);
  CHECK(pair.stretch() < 1e-15);
}

TEST_CASE("Anchors are dropped when the normal turns against a body", "[contact]") {
  const ContactPoints points = corners();
  Pair pair;
  pair.build(points);
  pair.build(points, cube_at({0.0003, 0, 0}, 2, Vec3::UnitX()));  // its cosine is above 0.999
  CHECK(pair.stretch() > 0.0002);
  pair.build(points, cube_at({0.0003, 0, 0}, 3, Vec3::UnitX()));
  CHECK(pair.stretch() < 1e-15);
}

TEST_CASE("A cube that turns on the table keeps its anchors", "[contact]") {
  Pair pair;
  pair.build(corners());
  pair.build(corners(), cube_at(Vec3::Zero(), 5));
  CHECK(pair.spec().num_anchors == 2);
  CHECK(pair.stretch() > 0.002);
}

TEST_CASE("A single point has one anchor, and a second one grows beside it", "[contact]") {
  Pair pair;
  pair.build(points_at({{kHalf, 0, 0}}));
  REQUIRE(pair.spec().num_anchors == 1);
  pair.build(points_at({{kHalf, 0, 0}, {-kHalf, 0, 0}}), cube_at({0.0001, 0, 0}));
  REQUIRE(pair.spec().num_anchors == 2);
  CHECK(pair.spec().anchors_b[0].isApprox(Vec3(kHalf, 0, 0)));  // as it was
  CHECK(pair.spec().anchors_b[1].isApprox(Vec3(-kHalf, 0, 0)));
}

TEST_CASE("Two anchors give way when the points spread to twice as far", "[contact]") {
  Pair pair;
  pair.build(points_at({{0.004, 0, 0}, {-0.004, 0, 0}}));
  pair.build(points_at({{0.0079, 0, 0}, {-0.0079, 0, 0}}), cube_at({0.0001, 0, 0}));
  CHECK(pair.stretch() == Approx(0.0001));
  pair.build(points_at({{0.0081, 0, 0}, {-0.0081, 0, 0}}), cube_at({0.0001, 0, 0}));
  CHECK(pair.spec().num_anchors == 2);
  CHECK(pair.stretch() < 1e-15);
  CHECK((pair.spec().anchors_a[0] - pair.spec().anchors_a[1]).norm() == Approx(0.0162));
}

TEST_CASE("Points that are far above the table carry no friction", "[contact]") {
  Pair pair;
  REQUIRE(pair.build(corners(0.0041)) == 1);
  CHECK(pair.spec().num_points == 4);
  CHECK(pair.spec().num_anchors == 0);
  pair.build(corners(0.0039));
  CHECK(pair.spec().num_anchors == 2);
}

TEST_CASE("Points of two normals make two patches, those of a third are left out", "[contact]") {
  ContactPoints points = points_at({{0, 0, 0}, {0.01, 0, 0}});
  points.push({{0, 0.02, 0.02}, Vec3::UnitY(), 0});
  points.push({{0, 0, 0.005}, Vec3::UnitZ(), 0});
  points.push({{0.02, 0, 0.02}, Vec3::UnitX(), 0});
  Pair pair;
  REQUIRE(pair.build(points) == 2);
  CHECK(pair.spec(0).num_points == 3);
  // Those that come later stand first.
  CHECK(pair.spec(0).points[0].isApprox(Vec3(0, 0, 0.005)));
  CHECK(pair.spec(1).num_points == 1);
  CHECK(pair.spec(1).normal == Vec3::UnitY());
  CHECK(pair.memory().num_patches == 2);
}

TEST_CASE("A patch without points is forgotten", "[contact]") {
  Pair pair;
  pair.build(corners());
  CHECK(pair.build(points_at({{0, kHalf, kHalf}}, 0, Vec3::UnitY())) == 1);
  CHECK(pair.memory().num_patches == 1);
  CHECK(pair.build({}) == 0);
  CHECK(pair.memory().num_patches == 0);
}

}  // namespace
}  // namespace engram
