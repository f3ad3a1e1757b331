#include "render/make_renderer.h"

#include <catch2/catch.hpp>
#include <string>

#include "tests/render/render_fixture.h"

namespace engram::test {
namespace {

TEST_CASE("Renderers go by their names", "[render]") {
  RenderRig rig;
  rig.add(RenderShape::kBox, {1, 1, 1}, {4, 0, 0});
  ImageSourceOptions options;
  CHECK(make_renderer(rig.scene, options, 1)->name() == std::string("cpu"));
  CHECK(make_renderer_on(InstructionSet::kBaseline, rig.scene, options, 1)->name() ==
        std::string("cpu"));
  options.renderer = "pencil";
  CHECK_THROWS_WITH(make_renderer(rig.scene, options, 1),
                    Catch::Contains("pencil") && Catch::Contains("'cpu' or 'egl'"));
}

}  // namespace
}  // namespace engram::test
