// Cameras, contact pairs, and the agreement between the documents.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <random>
#include <set>
#include <utility>

#include "tests/mjcf/model.h"

namespace engram::mjcf::test {
namespace {

using Axes = std::array<std::array<double, 3>, 4>;  // position, right, up, forward

void check_camera(const Model& model, const Data& data, const char* name, const Axes& expected,
                  double margin) {
  INFO(name);
  const int camera = id(model, mjOBJ_CAMERA, name);
  const double* rotation = data->cam_xmat + 9 * camera;
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<size_t>(i);
    CHECK(data->cam_xpos[3 * camera + i] == Approx(expected[0][axis]).margin(margin));
    CHECK(rotation[3 * i] == Approx(expected[1][axis]).margin(margin));
    CHECK(rotation[3 * i + 1] == Approx(expected[2][axis]).margin(margin));
    CHECK(-rotation[3 * i + 2] == Approx(expected[3][axis]).margin(margin));
  }
}

TEST_CASE("Cameras stand and look as specified", "[mjcf][scene]") {
  const Axes base = {
      {{0.3, 0, 0.6}, {0, 1, 0}, {-0.780869, 0, 0.624695}, {-0.624695, 0, -0.780869}}};
  const Axes hand = {{{-0.0242, 0.0200, 0.3854}, {0, -1, 0}, {1, 0, 0}, {0, 0, -1}}};
  const std::pair<RenderCamera, Axes> render =
      GENERATE_COPY(std::pair{RenderCamera::kA, Axes{{{0.5, 1, 1},
                                                      {-0.780869, 0.624695, 0},
                                                      {-0.384473, -0.480592, 0.78817},
                                                      {-0.492366, -0.615457, -0.615457}}}},
                    std::pair{RenderCamera::kB, Axes{{{0.6, 0.7, 0.6},
                                                      {-0.759257, 0.650791, 0},
                                                      {-0.285459, -0.333035, 0.898666},
                                                      {-0.584844, -0.682318, -0.438633}}}},
                    std::pair{RenderCamera::kC, Axes{{{0.6, 0.7, 0.6},
                                                      {-0.759257, 0.650791, 0},
                                                      {-0.170320, -0.198707, 0.965146},
                                                      {-0.628109, -0.732793, -0.261712}}}});
  const Model model = compile({{}, render.first}, Detail::kFull);
  const Data data = make_data(model, kMikasa);
  check_camera(model, data, "base_camera", base, 1e-6);
  check_camera(model, data, "hand_camera", hand, 1e-4);
  check_camera(model, data, "render_camera", render.second, 1e-6);
  CHECK(model->cam_fovy[id(model, mjOBJ_CAMERA, "base_camera")] == 90);
  CHECK(model->cam_fovy[id(model, mjOBJ_CAMERA, "hand_camera")] == 90);
  CHECK(model->cam_fovy[id(model, mjOBJ_CAMERA, "render_camera")] == Approx(57.2958));
}

using BodyPair = std::pair<std::string, std::string>;

std::string body_of(const Model& model, int geom) {
  return mj_id2name(model.get(), mjOBJ_BODY, model->geom_bodyid[geom]);
}

std::set<BodyPair> body_pairs(const Model& model) {
  std::set<BodyPair> result;
  for (int i = 0; i < model->npair; ++i) {
    const std::string a = body_of(model, model->pair_geom1[i]);
    const std::string b = body_of(model, model->pair_geom2[i]);
    result.insert(std::minmax(a, b));
  }
  return result;
}

TEST_CASE("The robot collides with itself where upstream lets it", "[mjcf][scene]") {
  const std::pair<const char*, std::vector<const char*>> table[] = {
      {"link0", {"link5", "link6", "link7", "hand", "leftfinger", "rightfinger", "camera_link"}},
      {"link1", {"link5", "link6", "link7", "hand", "leftfinger", "rightfinger", "camera_link"}},
      {"link2", {"link5", "link7", "hand", "leftfinger", "rightfinger", "camera_link"}},
      {"link3", {"camera_link"}},
      {"link4", {"camera_link"}},
      {"link5", {"leftfinger", "rightfinger", "camera_link"}},
      {"world",
       {"link2", "link3", "link4", "link5", "link6", "link7", "hand", "leftfinger", "rightfinger",
        "camera_link"}},
  };
  std::set<BodyPair> expected;
  for (const auto& [link, others] : table) {
    for (const char* other : others) {
      expected.insert(std::minmax(std::string(link), std::string(other)));
    }
  }
  CHECK(body_pairs(compile({}, Detail::kRobotOnly)) == expected);
}

TEST_CASE("Nothing touches at the key poses", "[mjcf][scene]") {
  const Arm open = GENERATE(kRest, kBuilder, kMikasa, kMenagerie);
  const double fingers = GENERATE(0.0, 0.02, 0.04);
  Arm pose = open;
  pose[7] = pose[8] = fingers;
  const Model model = compile({}, Detail::kRobotOnly);
  CHECK(make_data(model, pose)->ncon == 0);
}

TEST_CASE("Pairs take the average friction", "[mjcf][scene]") {
  const Model model = compile(cubes(2), Detail::kPhysics);
  const auto is_finger = [](const std::string& body) { return body.ends_with("finger"); };
  for (int i = 0; i < model->npair; ++i) {
    const bool finger = is_finger(body_of(model, model->pair_geom1[i])) ||
                        is_finger(body_of(model, model->pair_geom2[i]));
    CHECK(model->pair_friction[5 * i] == Approx(finger ? 1.15 : 0.3));
    CHECK(model->pair_friction[5 * i + 1] == Approx(finger ? 1.15 : 0.3));
    CHECK(model->pair_dim[i] == 4);
  }
}

TEST_CASE("Props meet robot, table and each other as they should", "[mjcf][scene]") {
  Scene scene = cubes(1);
  for (const char* name : {"post", "wall"}) {
    Prop prop = cube(name, 0.02, {1, 1, 1, 1});
    prop.motion = Motion::kKinematic;
    scene.props.push_back(prop);
  }
  Prop ghost = cube("ghost", 0.02, {1, 1, 1, 0.5});
  ghost.primitives[0].collides = false;
  scene.props.push_back(ghost);

  const Model model = compile(scene, Detail::kPhysics);
  CHECK(model->nmocap == 2);
  const std::set<BodyPair> pairs = body_pairs(model);
  CHECK(pairs.contains({"cube0", "world"}));
  CHECK_FALSE(pairs.contains({"post", "world"}));
  CHECK(pairs.contains({"cube0", "post"}));
  CHECK(pairs.contains({"cube0", "wall"}));
  CHECK_FALSE(pairs.contains({"post", "wall"}));
  for (const char* link :
       {"link5", "link6", "link7", "hand", "camera_link", "leftfinger", "rightfinger"}) {
    for (const char* prop : {"cube0", "post"}) {
      CHECK(pairs.contains(std::minmax(std::string(link), std::string(prop))));
    }
  }
  for (const auto& [a, b] : pairs) CHECK((a != "ghost" && b != "ghost"));
  CHECK(id(model, mjOBJ_GEOM, "post_0") >= 0);
}

TEST_CASE("Robot indices agree with and without props", "[mjcf][scene]") {
  const Model bare = compile({}, Detail::kRobotOnly);
  const Model full = compile(cubes(3), Detail::kPhysics);
  REQUIRE(full->ngeom > bare->ngeom);
  const std::pair<mjtObj, int> kinds[] = {
      {mjOBJ_BODY, bare->nbody}, {mjOBJ_JOINT, bare->njnt},  {mjOBJ_GEOM, bare->ngeom},
      {mjOBJ_SITE, bare->nsite}, {mjOBJ_ACTUATOR, bare->nu}, {mjOBJ_TENDON, bare->ntendon}};
  for (const auto& [kind, count] : kinds) {
    for (int i = 0; i < count; ++i) {
      CHECK(std::string(mj_id2name(bare.get(), kind, i)) == mj_id2name(full.get(), kind, i));
    }
  }
  // MuJoCo sorts the pairs, so that only their set can agree.
  const auto pairs = [](const Model& model) {
    std::set<std::pair<int, int>> result;
    for (int i = 0; i < model->npair; ++i) {
      result.insert(std::minmax(model->pair_geom1[i], model->pair_geom2[i]));
    }
    return result;
  };
  const auto own = pairs(bare);
  const auto all = pairs(full);
  CHECK(std::includes(all.begin(), all.end(), own.begin(), own.end()));
}

// Moves the targets at random as the control loop would.
class RandomTargets {
 public:
  void apply(mjData& data) {
    std::uniform_real_distribution<double> delta(-0.15, 0.15);
    std::uniform_real_distribution<double> fingers(-0.01, 0.04);
    for (int i = 0; i < 7; ++i) data.ctrl[i] = data.qpos[i] + delta(engine_);
    data.ctrl[7] = data.ctrl[8] = fingers(engine_);
  }

 private:
  std::mt19937 engine_{1};
};

TEST_CASE("Visual geometry changes no bit of the physics", "[mjcf][scene]") {
  Scene scene = cubes(4);
  scene.props[0].pos = {-0.07, 0, 0.3};  // starts in the gripper, then falls
  const Model full = compile_driven(scene, Detail::kFull);
  const Model physics = compile_driven(scene, Detail::kPhysics);
  REQUIRE(full->nq == physics->nq);
  const Data a = make_data(full, kMikasa);
  const Data b = make_data(physics, kMikasa);

  RandomTargets first, second;
  int contacts = 0;
  for (int i = 0; i < 500; ++i) {
    if (i % 5 == 0) {
      first.apply(*a);
      second.apply(*b);
    }
    step(full, a);
    step(physics, b);
    contacts += b->ncon;
    REQUIRE(std::memcmp(a->qpos, b->qpos, sizeof(mjtNum) * static_cast<size_t>(full->nq)) == 0);
  }
  CHECK(contacts > 1000);
}

TEST_CASE("Buffers hold whatever happens", "[mjcf][scene]") {
  // A heap of cubes dropped on each other, under a flailing arm.
  Scene scene = cubes(15);
  for (size_t i = 0; i < scene.props.size(); ++i) {
    const double layer = static_cast<double>(i / 4);
    scene.props[i].pos = {-0.05 + 0.041 * static_cast<double>(i % 2),
                          0.041 * static_cast<double>(i / 2 % 2), 0.02 + 0.041 * layer};
  }
  const Model model = compile_driven(scene, Detail::kPhysics);
  const Data data = make_data(model, kMikasa);
  RandomTargets targets;
  int rows = 0;
  for (int i = 0; i < 500; ++i) {
    if (i % 5 == 0) targets.apply(*data);
    step(model, data);
    rows = std::max(rows, data->nefc);
  }
  for (const mjWarningStat& warning : data->warning) CHECK(warning.number == 0);
  CHECK(rows < model->njmax / 2);
  CHECK(data->maxuse_stack < model->nstack / 2);
}

}  // namespace
}  // namespace engram::mjcf::test
