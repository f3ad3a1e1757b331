#include "media/overlay.h"

#include <catch2/catch.hpp>
#include <cstdlib>

#include "core/batch/scene_renderer.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

// The overlay of a task of that id over its first environment.
Overlay overlay_of(const char* id, double target) {
  const BatchOptions options{.threads = 1,
                             .pins = {{make_task(id)->info().hidden_variable, {target}}}};
  Batch batch(make_task(id), options);
  batch.reset();
  Overlay overlay = make_overlay(512, 512);
  SceneRenderer(batch).overlay(0, overlay);
  return overlay;
}

Color pixel(const Canvas& canvas, int x, int y) {
  const auto rgb = canvas.rgb();
  const auto at = 3 * static_cast<std::size_t>(y * canvas.width() + x);
  return {rgb[at], rgb[at + 1], rgb[at + 2]};
}

int whites(const Canvas& canvas, int left, int top, int right, int bottom) {
  int found = 0;
  const auto rgb = canvas.rgb();
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) {
      const auto at = 3 * static_cast<std::size_t>(y * canvas.width() + x);
      if (rgb[at] == 255 && rgb[at + 1] == 255 && rgb[at + 2] == 255) ++found;
    }
  }
  return found;
}

}  // namespace

TEST_CASE("overlay: RememberColor shows the target's colour", "[render]") {
  const Color colors[] = {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}};
  for (int target = 0; target < 3; ++target) {
    const Overlay overlay = overlay_of("RememberColor3-VLA-v0", target);
    REQUIRE(overlay.items.size() == 2);
    const auto& text = std::get<OverlayText>(overlay.items[0]);
    CHECK(text.text == "Target:");
    CHECK(text.baseline.x == 10);
    CHECK(text.baseline.y == 60);
    CHECK(text.scale == 1);
    const auto& swatch = std::get<OverlaySwatch>(overlay.items[1]);
    CHECK(swatch.corner.y == 38);
    CHECK(swatch.size == 22);

    Canvas canvas(512, 512);
    draw_overlay(overlay, {0, 0}, 512, canvas);
    const auto x = static_cast<int>(swatch.corner.x);
    CHECK(pixel(canvas, x + 11, 49) == colors[target]);
    CHECK(pixel(canvas, x, 38) == kWhite);
    CHECK(pixel(canvas, x + 21, 59) == kWhite);
    CHECK(whites(canvas, 10, 39, x - 4, 61) > 100);
  }
}

TEST_CASE("overlay: shapes are named, with their colour where it matters", "[render]") {
  for (const char* id : {"RememberShape9-VLA-v0", "FindImposterShape9-VLA-v0"}) {
    const Overlay overlay = overlay_of(id, 6);
    REQUIRE(overlay.items.size() == 1);
    const auto& text = std::get<OverlayText>(overlay.items[0]);
    CHECK(text.text == "Target: pyramide");
    CHECK(text.baseline.x == 10);
    CHECK(text.baseline.y == 60);
  }
  for (const char* id :
       {"RememberShapeAndColor5x3-VLA-v0", "FindImposterShapeAndColor5x3-VLA-v0"}) {
    const Overlay overlay = overlay_of(id, 7);
    REQUIRE(overlay.items.size() == 3);
    const auto& text = std::get<OverlayText>(overlay.items[0]);
    const auto& swatch = std::get<OverlaySwatch>(overlay.items[1]);
    const auto& name = std::get<OverlayText>(overlay.items[2]);
    CHECK(text.text == "Target:");
    CHECK(swatch.corner.y == 38);
    CHECK(swatch.color.red == 0);
    CHECK(swatch.color.green == 255);
    CHECK(swatch.color.blue == 0);
    CHECK(name.text == "t_shape");
    CHECK(name.baseline.x > swatch.corner.x + swatch.size);
    CHECK(name.baseline.y == 60);
  }
}

TEST_CASE("overlay: step and reward, the latter unless it is disabled", "[render]") {
  ::unsetenv("MIKASA_DISABLE_REWARD_OVERLAY");
  Overlay overlay = make_overlay(512, 512);
  add_step(overlay, 12);
  add_reward(overlay, -0.0236);
  REQUIRE(overlay.items.size() == 2);
  const auto& step = std::get<OverlayText>(overlay.items[0]);
  CHECK(step.text == "Step: 12");
  CHECK(step.baseline.y == 30);
  const auto& reward = std::get<OverlayText>(overlay.items[1]);
  CHECK(reward.text == "Reward: -0.024");
  CHECK(reward.baseline.y == 90);

  ::setenv("MIKASA_DISABLE_REWARD_OVERLAY", "1", 1);
  add_reward(overlay, 1);
  CHECK(overlay.items.size() == 2);
  ::setenv("MIKASA_DISABLE_REWARD_OVERLAY", "0", 1);
  add_reward(overlay, 1);
  CHECK(overlay.items.size() == 3);
  ::unsetenv("MIKASA_DISABLE_REWARD_OVERLAY");
}

TEST_CASE("overlay: grows and shrinks with the image and stays in its place", "[render]") {
  CHECK(make_overlay(1024, 512).width == 1024);
  CHECK(make_overlay(300, 600).height == 1024);
  Overlay overlay = make_overlay(256, 256);
  overlay.add(OverlaySwatch{{100, 40}, 20, {255, 0, 0}});
  overlay.add(OverlayPanel{{200, 200}, 40, 20, {0, 0, 255}});
  overlay.add(OverlayDisc{{300, 300}, 20, {0, 255, 0}});
  overlay.add(OverlayLine{{{400, 400}, {500, 400}}, 8, {255, 255, 0}});
  Canvas canvas(400, 300);
  draw_overlay(overlay, {100, 0}, 256, canvas);
  CHECK(pixel(canvas, 155, 25) == Color{255, 0, 0});
  CHECK(pixel(canvas, 105, 25) == kBlack);
  CHECK(pixel(canvas, 210, 105) == Color{0, 0, 255});
  CHECK(pixel(canvas, 250, 150) == Color{0, 255, 0});
  CHECK(pixel(canvas, 325, 200) == Color{255, 255, 0});
}

}  // namespace engram
