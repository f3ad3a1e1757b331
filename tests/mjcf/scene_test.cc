// Agreement between the documents of a scene, and the size of their buffers.
#include "mjcf/scene.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <random>
#include <set>
#include <utility>

#include "tests/mjcf/model.h"

namespace engram::mjcf::test {
namespace {

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

TEST_CASE("Buffers hold a heap of props under a moving arm", "[mjcf][scene]") {
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
#if mjVERSION_HEADER >= 300
  CHECK(data->maxuse_arena < data->narena / 2);
#else
  CHECK(data->maxuse_stack < model->nstack / 2);
#endif
}

TEST_CASE("The plain Panda is the same robot without the camera on its hand", "[mjcf][scene]") {
  Scene scene = cubes(2);
  scene.wrist_camera = false;
  for (const Detail detail : {Detail::kFull, Detail::kPhysics, Detail::kRobotOnly}) {
    const Model with = compile(cubes(2), detail);
    const Model without = compile(scene, detail);
    REQUIRE(without->nbody == with->nbody);
    const int camera = id(without, mjOBJ_BODY, "camera_link");
    CHECK(without->body_mass[camera] == 0);
    CHECK(without->body_geomnum[camera] == 0);
    CHECK(with->body_geomnum[camera] > 0);
    for (int body = 0; body < with->nbody; ++body) {
      CHECK(std::string(mj_id2name(without.get(), mjOBJ_BODY, body)) ==
            mj_id2name(with.get(), mjOBJ_BODY, body));
      if (body != camera) CHECK(without->body_mass[body] == with->body_mass[body]);
    }
    CHECK(with->body_subtreemass[0] - without->body_subtreemass[0] == Approx(0.564));
    CHECK(without->npair < with->npair);
    CHECK(without->ncam == with->ncam);
  }
}

}  // namespace
}  // namespace engram::mjcf::test
