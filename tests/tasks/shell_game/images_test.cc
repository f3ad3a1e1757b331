// What images of shell games show: lamps of each environment's own colour, goals for people only.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "core/batch/scene_renderer.h"
#include "protocol/make/make.h"
#include "tests/env_helpers.h"
#include "tests/render/has_egl.h"

namespace {

using namespace engram;

using Rgb = std::array<std::uint8_t, 3>;

int count_pixels(Batch& batch, int index, const char* camera, const Rgb& color) {
  std::vector<std::uint8_t> rgb(std::size_t{128} * 128 * 3);
  SceneRenderer(batch).render(index, camera, 128, 128, rgb);
  int count = 0;
  for (std::size_t i = 0; i < rgb.size(); i += 3) {
    count += std::equal(color.begin(), color.end(), &rgb[i]) ? 1 : 0;
  }
  return count;
}

void check_lamps(const std::string& renderer) {
  BatchOptions options{.num_envs = 3};
  options.image_options.renderer = renderer;
  options.pins = {{"base", {0, 0}}, {"cue_steps", {1}}};
  const auto batch = make("ShellGameColorLampTouch-VLA-v0", options);
  for (int color = 0; color < 3; ++color) {
    const std::vector<Pin> pins = {
        {"base", {0, 0}}, {"cue_steps", {1}}, {"target_color", {static_cast<double>(color)}}};
    std::vector<std::uint8_t> mask(3, color == 0 ? 1 : 0);
    mask[static_cast<std::size_t>(color)] = 1;
    batch->reset({.mask = mask, .seeds = {}, .pins = &pins});
  }
  const Rgb colors[] = {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}};
  // Unlit, the bulb is white, brightest where it faces the lights; no colour is saturated but the
  // balls' upper sides, which are small.
  std::vector<float> rest = test::zeros(*batch);
  std::array<std::array<int, 3>, 3> before{};
  for (int index = 0; index < 3; ++index) {
    for (std::size_t k = 0; k < 3; ++k) {
      before[static_cast<std::size_t>(index)][k] =
          count_pixels(*batch, index, "base_camera", colors[k]);
      CHECK(before[static_cast<std::size_t>(index)][k] < 10);
    }
  }
  batch->step(rest);
  for (int index = 0; index < 3; ++index) {
    for (int k = 0; k < 3; ++k) {
      INFO(renderer << ", environment " << index << ", colour " << k);
      const int lit = count_pixels(*batch, index, "base_camera", colors[k]);
      CHECK((k == index ? lit > 80 : lit == 0));
    }
  }
}

TEST_CASE("Every environment's lamp has its own colour", "[render][shell]") {
  check_lamps("cpu");
  if (has_egl()) check_lamps("egl");
}

TEST_CASE("People see the goal of Push and Pick, sensors do not", "[render][shell]") {
  for (const char* id : {"ShellGamePush-VLA-v0", "ShellGamePick-VLA-v0"}) {
    const BatchOptions options{.pins = {{"base", {0, 0}}, {"cup_with_ball_number", {1}}}};
    const auto batch = make(id, options);
    batch->reset();
    const auto green = [&batch](const char* camera) {
      std::vector<std::uint8_t> rgb(std::size_t{128} * 128 * 3);
      SceneRenderer(*batch).render(0, camera, 128, 128, rgb);
      int count = 0;
      for (std::size_t i = 0; i < rgb.size(); i += 3) {
        count += rgb[i] < 10 && rgb[i + 1] > 100 && rgb[i + 2] < 10 ? 1 : 0;
      }
      return count;
    };
    INFO(id);
    CHECK(green("render_camera") > 30);
    CHECK(green("base_camera") == 0);
    CHECK(green("hand_camera") == 0);
  }
}

}  // namespace
