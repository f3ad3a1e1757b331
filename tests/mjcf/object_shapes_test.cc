// The nine shapes: geoms, mass properties and rest.
#include "mjcf/object_shapes.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "mjcf/table_contact.h"
#include "tests/mjcf/model.h"

namespace engram::mjcf::test {
namespace {

constexpr Rgba kBlue = {0, 0, 1, 1};

std::vector<ObjectShape> all_shapes() {
  std::vector<ObjectShape> shapes;
  shapes.reserve(kObjectShapeCount);
  for (int i = 0; i < kObjectShapeCount; ++i) shapes.push_back(static_cast<ObjectShape>(i));
  return shapes;
}

Prop shape(ObjectShape which) { return shape_prop("shape", which, kBlue); }

// Published masses, inertias and heights.
struct Derived {
  const char* name;
  std::size_t geoms;
  double mass;
  Vec3 center_of_mass;
  Vec3 inertia;
  double resting_height;
};
constexpr std::array<Derived, kObjectShapeCount> kDerived = {{
    {"cube", 1, 0.064000, {}, {1.70667e-5, 1.70667e-5, 1.70667e-5}, 0.02},
    {"sphere", 1, 0.033510, {}, {5.36165e-6, 5.36165e-6, 5.36165e-6}, 0.02},
    {"cylinder", 1, 0.050265, {}, {1.17286e-5, 1.17286e-5, 1.00531e-5}, 0.02},
    {"cross", 2, 0.027000, {}, {4.80937e-6, 4.80937e-6, 8.60625e-6}, 0.0075},
    {"torus", 8, 0.038472, {}, {8.28049e-6, 8.28049e-6, 1.50586e-5}, 0.00765367},
    {"star", 5, 0.033750, {}, {6.01172e-6, 6.01172e-6, 1.07578e-5}, 0.0075},
    {"pyramide", 3, 0.026400, {0, 0, 0.0049091}, {4.09194e-6, 4.09194e-6, 5.40032e-6}, 0.005},
    {"t_shape", 2, 0.018000, {0, 0.02625, 0}, {2.40938e-6, 1.70625e-6, 3.44062e-6}, 0.0075},
    {"crescent",
     24,
     0.032191,
     {0.0009726, 0.0094643, 0},
     {2.33911e-6, 6.35175e-6, 8.56047e-6},
     0.00284630},
}};

TEST_CASE("Shapes weigh and stand as published", "[mjcf][shapes]") {
  for (const ObjectShape which : all_shapes()) {
    const Derived& expected = kDerived[static_cast<std::size_t>(which)];
    const Prop prop = shape_prop("it", which, kBlue);
    INFO(expected.name);
    CHECK(shape_name(which) == expected.name);
    CHECK(prop.name == "it");
    CHECK(prop.geoms.size() == expected.geoms);
    CHECK(prop.mass == Approx(expected.mass).margin(6e-7));
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(prop.center_of_mass[k] == Approx(expected.center_of_mass[k]).margin(6e-8));
      CHECK(prop.inertia[k] == Approx(expected.inertia[k]).epsilon(3e-6));
    }
    const double product = which == ObjectShape::kCrescent ? -2.41e-7 : 0;
    CHECK(prop.inertia[3] == Approx(product).margin(1e-9));
    CHECK(prop.inertia[4] == Approx(0).margin(1e-18));
    CHECK(prop.inertia[5] == Approx(0).margin(1e-18));
    CHECK(resting_height(which) == Approx(expected.resting_height).margin(6e-9));
    CHECK(prop.pos[2] == resting_height(which));
  }
}

TEST_CASE("A shape has the colour that it is given", "[mjcf][shapes]") {
  for (const ObjectShape which : all_shapes()) {
    const Prop prop = shape_prop("it", which, {0.2, 0.4, 0.6, 1});
    int visible = 0;
    for (const Geom& geom : prop.geoms) {
      if (!geom.visible) continue;
      ++visible;
      CHECK(geom.rgba == Rgba{0.2, 0.4, 0.6, 1});
    }
    const bool crescent = which == ObjectShape::kCrescent;
    CHECK(visible == (crescent ? 12 : static_cast<int>(prop.geoms.size())));
  }
}

void check_position(const Geom& geom, double x, double y) {
  CHECK(geom.pos[0] == Approx(x).margin(6e-9));
  CHECK(geom.pos[1] == Approx(y).margin(6e-9));
  CHECK(geom.pos[2] == 0);
}

TEST_CASE("Geoms lie where the published centres are", "[mjcf][shapes]") {
  const Prop torus = shape(ObjectShape::kTorus);
  check_position(torus.geoms[0], 0.01707107, 0.00707107);
  check_position(torus.geoms[2], -0.00707107, 0.01707107);
  CHECK(torus.geoms[5].size[0] == 0.01);
  CHECK(torus.geoms[5].size[1] == Approx(0.00765367).margin(6e-9));

  const Prop star = shape(ObjectShape::kStar);
  check_position(star.geoms[1], 0.00463525, 0.01426585);
  check_position(star.geoms[3], -0.01213525, -0.00881678);
  const double yaw = 2 * std::atan2(star.geoms[3].quat[3], star.geoms[3].quat[0]);
  CHECK(yaw == Approx(2 * kPi * 3 / 5));

  const Prop crescent = shape(ObjectShape::kCrescent);
  check_position(crescent.geoms[0], 0.01959493, 0.00281733);
  check_position(crescent.geoms[4], 0.00557730, 0.01899453);
  check_position(crescent.geoms[11], -0.01959493, -0.00281733);
  check_position(crescent.geoms[12], 0.01679746, 0.00140866);
  check_position(crescent.geoms[20], -0.00048057, 0.00648195);
  check_position(crescent.geoms[23], -0.00279746, -0.00140866);
  CHECK(crescent.geoms[0].size[1] == Approx(0.00284630).margin(6e-9));
  CHECK(crescent.geoms[12].size[1] == Approx(0.00142315).margin(6e-9));
  CHECK_FALSE(crescent.geoms[12].visible);

  const Prop pyramide = shape(ObjectShape::kPyramide);
  CHECK(pyramide.geoms[1].size == Vec3{0.7 * 0.02, 0.7 * 0.02, 0.005});
  CHECK(pyramide.geoms[2].size == Vec3{0.4 * 0.02, 0.4 * 0.02, 0.005});
  CHECK(pyramide.geoms[2].pos[2] == 0.02);

  const Prop t = shape(ObjectShape::kTShape);
  check_position(t.geoms[0], 0, 0.0325);
  check_position(t.geoms[1], 0, 0.02);
  CHECK(t.geoms[1].size == Vec3{0.0075, 0.02, 0.0075});
}

// True for a point in an upright disc.
bool inside(const Geom& disc, double x, double y, double z) {
  return std::hypot(x - disc.pos[0], y - disc.pos[1]) < disc.size[0] &&
         std::abs(z - disc.pos[2]) < disc.size[1];
}

TEST_CASE("The crescent collides with fewer discs, as the same solid", "[mjcf][shapes]") {
  const Prop crescent = shape(ObjectShape::kCrescent);
  std::vector<Geom> colliding;
  std::copy_if(crescent.geoms.begin(), crescent.geoms.end(), std::back_inserter(colliding),
               [](const Geom& p) { return p.collides; });
  CHECK(colliding.size() == 15);

  int within = 0;
  int beside_outer = 0;
  int different = 0;
  for (int i = -320; i <= 320; ++i) {
    for (int j = -200; j <= 320; ++j) {
      const auto in = [&](const Geom& p) { return inside(p, i * 1e-4, j * 1e-4, 0.001); };
      const bool before = std::any_of(crescent.geoms.begin(), crescent.geoms.end(), in);
      const bool after = std::any_of(colliding.begin(), colliding.end(), in);
      const bool outer = std::any_of(colliding.begin(), colliding.begin() + 12, in);
      within += before ? 1 : 0;
      beside_outer += before && !outer ? 1 : 0;
      different += before != after ? 1 : 0;
    }
  }
  CHECK(within > 150'000);
  CHECK(beside_outer > 30'000);  // the inner discs matter
  CHECK(different == 0);
}

// A crescent all of whose discs collide, or only those that the engine uses.
Prop crescent(bool all_discs) {
  Prop prop = shape_prop("crescent", ObjectShape::kCrescent, kBlue);
  for (Geom& geom : prop.geoms) geom.collides |= all_discs;
  return prop;
}

// Poses of a crescent at the origin and of a ball that runs into it, after half a second.
struct Collision {
  Collision(bool all_discs, const Prop& ball, double speed) {
    const Model model = compile_driven({{crescent(all_discs), ball}}, Detail::kPhysics);
    const Data data = make_data(model, kMikasa);
    data->qvel[9 + 6 + 1] = speed;
    for (int i = 0; i < 50; ++i) step(model, data);
    std::copy_n(data->qpos + 9, 7, crescent_pose.begin());
    std::copy_n(data->qpos + 16, 3, ball_pos.begin());
  }
  std::array<double, 7> crescent_pose{};
  Vec3 ball_pos{};
};

// Discs that lie within others make a contact stiffer, not different.
void check_same(const Collision& a, const Collision& b) {
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(a.crescent_pose[i] == Approx(b.crescent_pose[i]).margin(5e-4));
    CHECK(a.ball_pos[i] == Approx(b.ball_pos[i]).margin(1e-3));
  }
  for (std::size_t i = 3; i < 7; ++i) {
    CHECK(a.crescent_pose[i] == Approx(b.crescent_pose[i]).margin(5e-3));
  }
}

Prop ball(double radius, double mass) {
  Prop prop;
  prop.name = "ball";
  prop.geoms.push_back({.type = GeomType::kSphere, .size = {radius, 0, 0}});
  prop.mass = mass;
  prop.inertia.fill(0);
  std::fill_n(prop.inertia.begin(), 3, 0.4 * mass * radius * radius);
  return prop;
}

// Contact of a kinematic probe with a crescent at the origin.
class Touch {
 public:
  Touch(bool all_discs, const Prop& probe)
      : model_(compile({{crescent(all_discs), probe}}, Detail::kPhysics)),
        data_(make_data(model_, kMikasa)),
        body_(id(model_, mjOBJ_BODY, probe.name)) {}

  bool at(const Vec3& pos) {
    std::copy(pos.begin(), pos.end(), data_->mocap_pos);
    mj_kinematics(model_.get(), data_.get());
    mj_collision(model_.get(), data_.get());
    return std::any_of(data_->contact, data_->contact + data_->ncon, [&](const mjContact& contact) {
      return model_->geom_bodyid[contact.geom1] == body_ ||
             model_->geom_bodyid[contact.geom2] == body_;
    });
  }

 private:
  Model model_;
  Data data_;
  int body_;
};

TEST_CASE("A finger feels the same crescent in and around its hole", "[mjcf][shapes]") {
  Prop fingertip = ball(0.004, 0);
  fingertip.body_type = BodyType::kKinematic;
  Touch few(false, fingertip);
  Touch all(true, fingertip);
  int touches = 0;
  int different = 0;
  for (double x = -0.034; x < 0.034; x += 0.0013) {
    for (double y = -0.02; y < 0.034; y += 0.0013) {
      for (const double z : {0.0051, 0.0075, 0.0079, 0.0092}) {
        const bool expected = all.at({x, y, z});
        touches += expected ? 1 : 0;
        different += few.at({x, y, z}) != expected ? 1 : 0;
      }
    }
  }
  CHECK(touches > 3000);
  CHECK(different == 0);
}

TEST_CASE("The crescent is pushed as if all its discs collided", "[mjcf][shapes]") {
  constexpr double kPushed = mjVERSION_HEADER < 300 ? 0.01 : 0.009;  // m, at least
  Prop pusher = ball(0.01, 0.2);
  // Into the mouth, against its edges, and against the rim.
  for (const double x : {0.0, 0.008, -0.01, 0.02}) {
    pusher.pos = {x, -0.04, 0.01};
    const Collision few(false, pusher, 0.2);
    INFO("at x = " << x);
    CHECK(std::hypot(few.crescent_pose[0], few.crescent_pose[1]) > kPushed);
    check_same(few, {true, pusher, 0.2});
  }
}

// A shape left alone on the table.
struct Alone {
  Alone(ObjectShape which, double height) {
    Prop prop = shape_prop("shape", which, kBlue);
    prop.pos = {0.1, 0.1, height};
    model = compile_driven({{prop}}, Detail::kPhysics);
    data = make_data(model, kMikasa);
  }
  // Steps on and returns the largest speeds meanwhile.
  struct Speeds {
    double linear = 0;
    double angular = 0;
  };
  Speeds run(int steps) {
    Speeds most;
    for (int i = 0; i < steps; ++i) {
      step(model, data);
      most.linear = std::max(most.linear, mju_norm3(data->qvel + 9));
      most.angular = std::max(most.angular, mju_norm3(data->qvel + 12));
    }
    return most;
  }
  const double* pos() const { return data->qpos + 9; }
  double tilt() const { return 2 * std::asin(std::hypot(data->qpos[13], data->qpos[14])); }

  Model model;
  Data data{nullptr, mj_deleteData};
};

void check_rests(const Alone& alone, double height) {
  CHECK(alone.pos()[0] == Approx(0.1).margin(1e-6));
  CHECK(alone.pos()[1] == Approx(0.1).margin(1e-6));
  CHECK(alone.pos()[2] == Approx(height).margin(2e-5));
  CHECK(alone.tilt() < 2e-4);
}

TEST_CASE("Shapes wake without a jolt and rest without creep", "[mjcf][shapes]") {
  for (const ObjectShape which : all_shapes()) {
    INFO(shape_name(which));
    const double height = resting_height(which);
    Alone alone(which, height);
    const Alone::Speeds waking = alone.run(20);
    CHECK(waking.linear < 5e-4);
    CHECK(waking.angular < 5e-3);
    const Alone::Speeds resting = alone.run(300);
    CHECK(resting.linear < 1e-4);
    CHECK(resting.angular < 1e-3);
    const Alone::Speeds later = alone.run(100);
    CHECK(later.linear < 1e-9);
    CHECK(later.angular < 1e-9);
    check_rests(alone, height);
  }
}

TEST_CASE("Shapes that appear above the table land flat and stay", "[mjcf][shapes]") {
  for (const ObjectShape which : all_shapes()) {
    INFO(shape_name(which));
    Alone alone(which, 0.02);
    alone.run(20);
    const Alone::Speeds landed = alone.run(25);
    CHECK(landed.linear < 5e-3);  // slow enough to fall asleep
    CHECK(landed.angular < 5e-2);
    check_rests(alone, resting_height(which));
  }
}

TEST_CASE("Resting contacts are counted as MuJoCo makes them", "[mjcf][shapes]") {
  for (const ObjectShape which : all_shapes()) {
    INFO(shape_name(which));
    const Alone alone(which, resting_height(which));
    const mjContact* contacts = alone.data->contact;
    const auto pushing =
        std::count_if(contacts, contacts + alone.data->ncon,
                      [](const mjContact& contact) { return contact.exclude == 0; });
    CHECK(pushing == table_contact_count(shape(which)));
  }
}

}  // namespace
}  // namespace engram::mjcf::test
