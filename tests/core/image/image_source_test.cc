// Rows that an image source gives its renderer.
#include "core/image/image_source.h"

#include <catch2/catch.hpp>

#include "core/base/error.h"

namespace engram {
namespace {

constexpr const char* kDocument = R"(
<mujoco>
  <worldbody>
    <geom name="table" type="box" size="1 1 0.1" rgba="0.2 0.2 0.2 1"/>
    <camera name="front" pos="0 -1 1"/>
    <body name="cube" pos="0 0 0.5">
      <geom type="box" size="0.1 0.1 0.1" rgba="1 0 0 1"/>
    </body>
  </worldbody>
</mujoco>)";

// The rows of the last image of the table and the cube.
struct Rows {
  float cube_pose[12] = {};
  float rgba[4] = {};
  float emission = 0;
  bool visible = true;
  bool table_is_still = false;
  bool cube_is_still = true;
};

class RowRecorder final : public Renderer {
 public:
  RowRecorder(const RenderScene& scene, Rows& rows) : rows_(rows) {
    rows.table_is_still = scene.geoms[0].still;
    rows.cube_is_still = scene.geoms[1].still;
  }
  const char* name() const override { return "recorder"; }
  void render(int, const RenderInstances& instances, std::span<const RenderImage>) override {
    std::copy_n(instances.geom_pose + 12, 12, rows_.cube_pose);
    std::copy_n(instances.geom_rgba + 4, 4, rows_.rgba);
    rows_.emission = instances.geom_emission[1];
    rows_.visible = instances.geom_visible[1] != 0;
  }

 private:
  Rows& rows_;
};

RendererFactory recorder(Rows& rows) {
  return [&rows](const RenderScene& scene, const ImageSourceOptions&, int) {
    return std::make_unique<RowRecorder>(scene, rows);
  };
}

TEST_CASE("Bodies are drawn where their views have them, and as they are painted", "[render]") {
  Rows rows;
  ImageSource source(kDocument, {"cube"}, {}, 1, recorder(rows));
  CHECK(source.cameras() == std::vector<std::string>{"front"});
  CHECK(source.segments() == std::vector<std::string>{"background", "table", "cube"});
  CHECK(rows.table_is_still);
  CHECK_FALSE(rows.cube_is_still);

  BodyView view;
  view.frame.pos = {0.25, 0.5, 0.75};
  source.render(0, {&view, 1}, {});
  CHECK(rows.cube_pose[9] == 0.25F);
  CHECK(rows.cube_pose[11] == 0.75F);
  CHECK(rows.rgba[0] == 1);
  CHECK(rows.visible);

  view.rgba[1] = view.rgba[3] = 1;
  view.emission = 0.5F;
  source.render(0, {&view, 1}, {});
  CHECK(rows.rgba[0] == 0);
  CHECK(rows.rgba[1] == 1);
  CHECK(rows.emission == 0.5F);

  view = {};
  view.visible = false;
  source.render(0, {&view, 1}, {});
  CHECK_FALSE(rows.visible);
  CHECK(rows.rgba[0] == 1);  // the document's colour again
}

TEST_CASE("A body that the document lacks is refused by name", "[render]") {
  Rows rows;
  CHECK_THROWS_WITH(ImageSource(kDocument, {"sphere"}, {}, 1, recorder(rows)),
                    Catch::Contains("sphere"));
}

}  // namespace
}  // namespace engram
