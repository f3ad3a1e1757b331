// Whether pictures after the cue tell what it has shown.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/batch/make.h"
#include "tests/differing_pixels.h"
#include "tests/env_helpers.h"

namespace engram::test {

// Two sets of values of a hidden draw, as different as possible.
inline std::vector<double> hidden_values(const Draw& draw, bool other) {
  const auto width = static_cast<std::size_t>(draw.width);
  // The largest contours would push the green cube, and that would tell.
  const bool radius = draw.name == "radius" || draw.name == "radii";
  const double large = radius ? std::clamp(0.10, draw.low, draw.high) : draw.high;
  std::vector<double> values(width, other ? large : draw.low);
  for (std::size_t i = 0; draw.distinct && i < width; ++i) {
    values[i] += (other ? -1.0 : 1.0) * static_cast<double>(i);
  }
  return values;
}

// As many values as the draw has, and within its bounds.
inline void fit(Pin& pin, const std::vector<Draw>& draws) {
  const auto draw = std::ranges::find(draws, pin.name, &Draw::name);
  if (draw == draws.end()) return;
  pin.values.resize(static_cast<std::size_t>(draw->width), pin.values.front());
  for (double& value : pin.values) value = std::clamp(value, draw->low, draw->high);
}

// A batch of one environment whose hidden draw has the one or the other values.
inline std::unique_ptr<VectorEnv> make_hiding(const std::string& id, const ConstantTable& constants,
                                              std::uint64_t seed, const Draw& draw, bool second) {
  EnvOptions options;
  options.seed = seed;
  options.threads = 1;
  options.auto_reset = AutoReset::kOff;
  options.constants = constants;
  auto env = make(id, options);
  std::vector<Pin> pins = undisturbed(id);
  for (Pin& pin : pins) fit(pin, env->info().draws);
  std::erase_if(pins, [&draw](const Pin& pin) { return pin.name == draw.name; });
  pins.push_back({draw.name, hidden_values(draw, second)});
  env->reset({.mask = {}, .seeds = {}, .pins = &pins});
  return env;
}

// What an episode hides; null where nothing is hidden at a set time.
inline std::unique_ptr<Draw> hidden_draw(const TaskInfo& info) {
  for (const Draw& draw : info.draws) {
    if (draw.name == info.hidden_draw) return std::make_unique<Draw>(draw);
  }
  return nullptr;
}

// How closely pictures are compared.
struct LeakCheck {
  int enough = 10;   // pixels in which a cue has to differ
  int closely = 60;  // control steps after the cue of which all are looked at, then one in fifty
};

// Plays two episodes that differ in what is hidden alone, the robot resting. While the cue is on, a
// policy can see the difference; afterwards there is none, in any camera. People may be shown where
// the goal is. Of long episodes a part of the steps is looked at.
inline void check_leaks(const std::string& id, const ConstantTable& constants, std::uint64_t seed,
                        const LeakCheck& check = {}) {
  const std::unique_ptr<Draw> draw = hidden_draw(make_task(id, constants)->info());
  if (!draw || hidden_values(*draw, false) == hidden_values(*draw, true)) return;
  const auto one = make_hiding(id, constants, seed, *draw, false);
  const auto other = make_hiding(id, constants, seed, *draw, true);
  const std::vector<float> rest = zeros(*one);
  // Who only rests is shown nothing; such families have tests of their own.
  if (one->cue_end(0) >= one->info().horizon) return;

  // Where the hidden draw tells the length of the cue, the cue is over when the longer one is.
  const int end = std::max(one->cue_end(0), other->cue_end(0));
  int seen = 0;
  for (; one->state().elapsed[0] < end; one->step(rest), other->step(rest)) {
    for (const char* sensor : {"base_camera", "hand_camera"}) {
      if (seen >= check.enough) break;
      seen = std::max(seen, differing_pixels(*one, *other, sensor));
    }
  }
  CHECK(seen >= check.enough);
  const bool goal_for_people = require_entry(id).definition->expectations.goal_for_people;
  for (; one->state().finished[0] == 0; one->step(rest), other->step(rest)) {
    const int since_cue = one->state().elapsed[0] - end;
    if (since_cue > check.closely && since_cue % 50 != 0) continue;
    for (const char* camera : {"base_camera", "hand_camera", "render_camera"}) {
      if (goal_for_people && camera == std::string_view("render_camera")) continue;
      REQUIRE(differing_pixels(*one, *other, camera) == 0);
    }
  }
}

}  // namespace engram::test
