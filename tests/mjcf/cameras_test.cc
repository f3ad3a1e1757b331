#include "mjcf/cameras.h"

#include <catch2/catch.hpp>
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

TEST_CASE("Cameras stand and look as specified", "[mjcf][cameras]") {
  const Axes base = {
      {{0.3, 0, 0.6}, {0, 1, 0}, {-0.780869, 0, 0.624695}, {-0.624695, 0, -0.780869}}};
  const Axes hand = {{{-0.0242, 0.0200, 0.3854}, {0, -1, 0}, {1, 0, 0}, {0, 0, -1}}};
  const std::pair<RenderView, Axes> render = GENERATE_COPY(
      std::pair{RenderView::kRobotAndTable, Axes{{{0.5, 1, 1},
                                                  {-0.780869, 0.624695, 0},
                                                  {-0.384473, -0.480592, 0.78817},
                                                  {-0.492366, -0.615457, -0.615457}}}},
      std::pair{RenderView::kTable, Axes{{{0.6, 0.7, 0.6},
                                          {-0.759257, 0.650791, 0},
                                          {-0.285459, -0.333035, 0.898666},
                                          {-0.584844, -0.682318, -0.438633}}}},
      std::pair{RenderView::kAboveTable, Axes{{{0.6, 0.7, 0.6},
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

}  // namespace
}  // namespace engram::mjcf::test
