#include "mjcf/scenery.h"

#include <Eigen/Dense>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <thread>

#include "core/scene/mujoco_versions.h"
#include "tests/mjcf/model.h"

namespace engram::mjcf::test {
namespace {

using Eigen::Vector3d;

// Name of the visible geom that a line of sight meets first, and the meeting point.
struct Sight {
  std::string name;
  Vector3d point;
};

// MuJoCo's rays meet planes of every group: the plane of contacts is passed.
Sight look(const Model& model, const Data& data, Vector3d eye, const Vector3d& target) {
  const Vector3d along = target - eye;
  for (;;) {
    const auto [distance, geom] = cast_ray(model, data, eye.data(), along.data(), kVisual);
    REQUIRE(geom >= 0);
    if (model->geom_group[geom] == kVisual) {
      const char* name = mj_id2name(model.get(), mjOBJ_GEOM, geom);
      return {name == nullptr ? "" : name, eye + distance * along};
    }
    eye += (distance + 1e-9) * along;
  }
}

const Vector3d kHumanEye(0.6, 0.7, 0.6);

TEST_CASE("People see the floor below the table's near edge", "[mjcf][scenery]") {
  const Model model = compile(Scene{}, Detail::kFull);
  const Data data = make_data(model, kMikasa);
  for (const double y : {0.0, 0.3, 0.6}) {
    CHECK(look(model, data, kHumanEye, {0.47, y, -0.3}).name == "ground");
    CHECK(look(model, data, kHumanEye, {0.46, y, 0}).name == "table");
    CHECK(look(model, data, kHumanEye, {0.469, y, -0.02}).name == "table");  // the board's edge
  }
}

TEST_CASE("The visible table ends where the original's does, a hair below the contacts' top",
          "[mjcf][scenery]") {
  const Model model = compile(Scene{}, Detail::kFull);
  const Data data = make_data(model, kMikasa);
  const auto below = [&](double x, double y) { return look(model, data, {x, y, 0.5}, {x, y, 0}); };
  CHECK(below(0.4685, 0).name == "table");
  CHECK(below(0.4695, 0).name == "ground");
  CHECK(below(-0.724, 1).name == "table");
  CHECK(below(-0.725, 1).name == "ground");
  CHECK(below(0.1, -1.208).name == "table");
  CHECK(below(0.1, -1.210).name == "ground");
  const double top = below(0.1, 0.5).point.z();
  CHECK(top < 0);
  CHECK(top > -0.001);
}

// Copies of all textures and of the materials' colours.
struct Colors {
  explicit Colors(const Model& model)
      : texels(texture_pixels(*model, 0), texture_pixels(*model, 0) + model->ntexdata),
        materials(model->mat_rgba, model->mat_rgba + 4 * model->nmat) {}
  std::vector<mjtByte> texels;
  std::vector<float> materials;
};

TEST_CASE("A scene's colours do not depend on who else draws from rand()", "[mjcf][scenery]") {
  const std::string text = compose(Scene{}, Detail::kFull);
  const Colors expected(compile_model(text));
  std::atomic<bool> done = false;
  std::thread other([&done] {
    while (!done) std::rand();
  });
  bool same = true;
  for (int i = 0; i < 20; ++i) {
    const Colors colors(compile_model(text));
    same = same && colors.texels == expected.texels && colors.materials == expected.materials;
  }
  done = true;
  other.join();
  CHECK(same);
}

}  // namespace
}  // namespace engram::mjcf::test
