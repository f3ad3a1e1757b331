#include "mjcf/panda_visual.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "tests/mjcf/model.h"

namespace engram::mjcf::test {
namespace {

using Eigen::Vector3d;

constexpr int kSize = 128;  // pixels

// Pixels of each body in a sensor camera's image of the robot at a pose.
std::map<std::string, int> count_pixels(const Model& model, const Data& data,
                                        const std::string& camera) {
  const int id = test::id(model, mjOBJ_CAMERA, camera);
  const Eigen::Map<const Vector3d> eye(data->cam_xpos + 3 * id);
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> axes(data->cam_xmat +
                                                                            9 * id);
  const double half = std::tan(model->cam_fovy[id] * kPi / 360);
  std::map<std::string, int> pixels;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const Vector3d ray((2 * (x + 0.5) / kSize - 1) * half, (1 - 2 * (y + 0.5) / kSize) * half,
                         -1);
      const Vector3d along = axes * ray;
      const Vector3d near = eye + 0.01 * along;  // the near plane
      const int geom = test::cast_ray(model, data, near.data(), along.data(), kVisual).geom;
      if (geom >= 0) ++pixels[mj_id2name(model.get(), mjOBJ_BODY, model->geom_bodyid[geom])];
    }
  }
  return pixels;
}

Arm start_pose(const std::array<double, 7>& noise) {
  Arm pose = kMikasa;
  for (std::size_t i = 0; i < noise.size(); ++i) pose[i] += noise[i];
  return pose;
}

TEST_CASE("Wrist, hand and camera share the image as in the original's", "[mjcf][panda]") {
  // Start poses; in the original, link 7 had 0.70 to 0.78 of the hand's pixels, the camera 0.24 to
  // 0.29, in eleven of them.
  const std::array<double, 7> poses[] = {
      {0.0354, -0.0017, -0.0133, -0.0098, 0.0409, -0.0136, -0.0238},
      {0.0354, -0.0136, -0.0238, 0.0209, -0.0267, -0.0156, -0.0217},
      {0.0354, -0.0203, 0.0052, -0.0274, -0.0006, 0.0283, 0.0274},
      {0.0354, -0.0274, -0.0006, 0.0283, 0.0274, 0.0103, 0.0248}};
  const Model model = compile(Scene{}, Detail::kFull);
  double flange = 0;
  double camera = 0;
  for (const auto& noise : poses) {
    auto pixels = count_pixels(model, make_data(model, start_pose(noise)), "base_camera");
    const double hand = pixels["hand"];
    REQUIRE(hand > 0);
    flange += pixels["link7"] / hand / 4;
    camera += pixels["camera_link"] / hand / 4;
  }
  CHECK(flange > 0.70);
  CHECK(flange < 0.78);
  CHECK(camera > 0.24);
  CHECK(camera < 0.29);
}

TEST_CASE("The wrist camera sees fingers, but neither hand nor its own case", "[mjcf][panda]") {
  const Model model = compile(Scene{}, Detail::kFull);
  const auto pixels = count_pixels(model, make_data(model, kMikasa), "hand_camera");
  CHECK(pixels.contains("leftfinger"));
  CHECK(pixels.contains("rightfinger"));
  for (const char* body : {"hand", "camera_link", "link7", "link6"}) {
    CHECK_FALSE(pixels.contains(body));
  }
}

}  // namespace
}  // namespace engram::mjcf::test
