#include "mjcf/contact_pairs.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <utility>

#include "tests/mjcf/model.h"

namespace engram::mjcf::test {
namespace {

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

TEST_CASE("The robot collides with itself where upstream lets it", "[mjcf][contact_pairs]") {
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

TEST_CASE("Nothing touches at the key poses", "[mjcf][contact_pairs]") {
  const Arm open = GENERATE(kRest, kBuilder, kMikasa, kMenagerie);
  const double fingers = GENERATE(0.0, 0.02, 0.04);
  Arm pose = open;
  pose[7] = pose[8] = fingers;
  const Model model = compile({}, Detail::kRobotOnly);
  CHECK(make_data(model, pose)->ncon == 0);
}

TEST_CASE("Pairs take the average friction", "[mjcf][contact_pairs]") {
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

TEST_CASE("Where the robot touches a prop, an overlap goes slowly", "[mjcf][contact_pairs]") {
  const Model model = compile(cubes(2), Detail::kPhysics);
  const auto is_prop = [](const std::string& body) { return body.starts_with("cube"); };
  for (int i = 0; i < model->npair; ++i) {
    const std::string a = body_of(model, model->pair_geom1[i]);
    const std::string b = body_of(model, model->pair_geom2[i]);
    const bool touch = is_prop(a) != is_prop(b) && a != "world" && b != "world";
    CHECK(model->pair_solref[2 * i] == (touch ? -1000 : 0.02));
    CHECK(model->pair_solref[2 * i + 1] == (touch ? -100 : 1));
  }
}

TEST_CASE("Props meet robot, table and each other as they should", "[mjcf][contact_pairs]") {
  Scene scene = cubes(1);
  for (const char* name : {"post", "wall"}) {
    Prop prop = cube(name, 0.02, {1, 1, 1, 1});
    prop.body_type = BodyType::kKinematic;
    scene.props.push_back(prop);
  }
  Prop ghost = cube("ghost", 0.02, {1, 1, 1, 0.5});
  ghost.geoms[0].collides = false;
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

}  // namespace
}  // namespace engram::mjcf::test
