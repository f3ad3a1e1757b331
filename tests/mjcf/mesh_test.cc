#include "mjcf/mesh.h"

#include <catch2/catch.hpp>
#include <vector>

#include "mjcf/inertia.h"
#include "mjcf/mesh_geom.h"
#include "mjcf/object_descriptor.h"
#include "mjcf/table_contact.h"
#include "tests/mjcf/model.h"

namespace engram::mjcf {
namespace {

// Corners of a box, and one point inside.
std::vector<Vec3> box_points(const Vec3& half, const Vec3& center) {
  std::vector<Vec3> points = {center};
  for (int i = 0; i < 8; ++i) {
    Vec3 point{};
    for (std::size_t k = 0; k < 3; ++k) {
      point[k] = center[k] + ((i >> k & 1) != 0 ? half[k] : -half[k]);
    }
    points.push_back(point);
  }
  return points;
}

constexpr Vec3 kHalf = {0.01, 0.02, 0.03};
constexpr Vec3 kCenter = {0.1, 0, 0.01};

TEST_CASE("A mesh of a box's corners has the box's inertia and size", "[mjcf][mesh]") {
  Prop box;
  box.geoms = {{.size = kHalf, .pos = kCenter}};
  set_solid_inertia(box);
  const Prop found = mesh("stone", box_points(kHalf, kCenter), {1, 0, 0, 1});
  CHECK(found.geoms[0].corners.size() == 8);
  CHECK(found.mass == Approx(box.mass));
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK(found.center_of_mass[k] == Approx(kCenter[k]).margin(1e-12));
    CHECK(describe_object(found).half_size[k] == Approx(kHalf[k]));
  }
  for (std::size_t i = 0; i < 6; ++i) {
    CHECK(found.inertia[i] == Approx(box.inertia[i]).margin(1e-12));
  }
  CHECK(found.pos[2] == Approx(0.02));
  CHECK(table_contact_count(found) == 4);
}

TEST_CASE("A turned mesh among other parts counts like a turned box", "[mjcf][mesh]") {
  const Quat turn = {0.8, 0.6, 0, 0};
  Prop boxes;
  boxes.geoms = {{.size = kHalf, .pos = {0, 0.05, 0}, .quat = turn}, {.size = kHalf}};
  Prop meshes = boxes;
  meshes.geoms[0] = mesh_geom(box_points(kHalf, {}));
  meshes.geoms[0].pos = {0, 0.05, 0};
  meshes.geoms[0].quat = turn;
  set_solid_inertia(boxes);
  set_solid_inertia(meshes);
  CHECK(meshes.mass == Approx(boxes.mass));
  for (std::size_t i = 0; i < 6; ++i) {
    CHECK(meshes.inertia[i] == Approx(boxes.inertia[i]).margin(1e-12));
  }
}

TEST_CASE("MuJoCo reads a mesh with its hull where the file has it", "[mjcf][mesh]") {
  Scene scene;
  scene.props = {mesh("stone", box_points(kHalf, kCenter), {1, 0, 0, 1})};
  for (const Detail detail : {Detail::kFull, Detail::kPhysics}) {
    const test::Model model = test::compile(scene, detail);
    const int geom = test::id(model, mjOBJ_GEOM, "stone_0");
    CHECK(model->geom_type[geom] == mjGEOM_MESH);
    CHECK(model->mesh_vertnum[model->geom_dataid[geom]] == 8);
    CHECK(model->geom_pos[3 * geom] == Approx(kCenter[0]));
    CHECK(model->geom_pos[3 * geom + 2] == Approx(kCenter[2]));
    const int body = test::id(model, mjOBJ_BODY, "stone");
    CHECK(model->body_mass[body] == Approx(scene.props[0].mass));
  }
}

TEST_CASE("Scenes without meshes have no assets for physics", "[mjcf][mesh]") {
  CHECK(compose(test::cubes(2), Detail::kPhysics).find("<asset") == std::string::npos);
}

}  // namespace
}  // namespace engram::mjcf
