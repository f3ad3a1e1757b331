// What the cue has shown must not be told by any later picture: else memory would not be needed.
#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "protocol/batch/make.h"
#include "tests/differing_pixels.h"
#include "tests/env_helpers.h"

namespace {

using namespace engram;
using test::differing_pixels;

constexpr std::uint64_t kEpisodes = 3;  // of long tasks: one
constexpr int kEnough = 10;             // pixels
constexpr const char* kCameras[] = {"base_camera", "hand_camera", "render_camera"};

// Two sets of values of a hidden draw, as different as possible.
std::vector<double> hidden_values(const Draw& draw, bool other) {
  const auto width = static_cast<std::size_t>(draw.width);
  // The largest contours would push the green cube, and that would tell.
  const bool radius = draw.name == "radius" || draw.name == "radii";
  std::vector<double> values(width, other ? (radius ? 0.10 : draw.high) : draw.low);
  for (std::size_t i = 0; draw.distinct && i < width; ++i) {
    values[i] += (other ? -1.0 : 1.0) * static_cast<double>(i);
  }
  return values;
}

// A batch whose environments share a seed, the hidden draw aside.
std::unique_ptr<VectorEnv> make_hiding(const std::string& id, std::uint64_t seed, const Draw& draw,
                                       bool second) {
  EnvOptions options;
  options.seed = seed;
  options.threads = 1;
  options.auto_reset = AutoReset::kOff;
  auto env = make(id, options);
  std::vector<Pin> pins = test::undisturbed(id);
  std::erase_if(pins, [&draw](const Pin& pin) { return pin.name == draw.name; });
  pins.push_back({draw.name, hidden_values(draw, second)});
  env->reset({.mask = {}, .seeds = {}, .pins = &pins});
  return env;
}

const Draw& hidden_draw(const std::string& id) {
  static std::unique_ptr<Task> task;
  task = make_task(id);
  for (const Draw& draw : task->info().draws) {
    if (draw.name == task->info().hidden_draw) return draw;
  }
  FAIL("task " << id << " does not say what it hides");
  throw;
}

// Steps long after the cue, in which nothing happens any more: one in fifty is looked at.
bool is_dull(int since_cue) { return since_cue > 60 && since_cue % 50 != 0; }

}  // namespace

TEST_CASE("No picture after the cue tells what was shown", "[render][long]") {
  for (const std::string& id : test::implemented_ids()) {
    if (make_task(id)->info().hidden_draw.empty()) continue;  // nothing is hidden at a set time
    const Draw draw = hidden_draw(id);
    const std::uint64_t episodes = require_entry(id).horizon > 100 ? 1 : kEpisodes;
    for (std::uint64_t seed = 0; seed < episodes; ++seed) {
      INFO(id << ", seed " << seed);
      const auto one = make_hiding(id, seed, draw, false);
      const auto other = make_hiding(id, seed, draw, true);
      const std::vector<float> rest = test::zeros(*one);
      // Who only rests is shown nothing; such families have tests of their own.
      if (one->cue_end(0) >= one->info().horizon) break;

      // While the cue is on, a policy can see the difference. Where it tells the length of the cue,
      // the cue is over when the longer one is.
      const int end = std::max(one->cue_end(0), other->cue_end(0));
      int seen = 0;
      for (; one->state().elapsed[0] < end; one->step(rest), other->step(rest)) {
        for (const char* sensor : {"base_camera", "hand_camera"}) {
          if (seen >= kEnough) break;
          seen = std::max(seen, differing_pixels(*one, *other, sensor));
        }
      }
      CHECK(seen >= kEnough);
      // Afterwards there is none, in any camera; people may be shown where the goal is. Of long
      // episodes a part of the steps is looked at.
      const bool goal_for_people = require_entry(id).definition->expectations.goal_for_people;
      for (; one->state().finished[0] == 0; one->step(rest), other->step(rest)) {
        if (is_dull(one->state().elapsed[0] - end)) continue;
        for (const char* camera : kCameras) {
          if (goal_for_people && camera == std::string_view("render_camera")) continue;
          REQUIRE(differing_pixels(*one, *other, camera) == 0);
        }
      }
    }
  }
}
