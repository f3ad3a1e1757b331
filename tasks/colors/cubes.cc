#include "tasks/colors/cubes.h"

#include <algorithm>
#include <numbers>
#include <string>

#include "core/base/real_functions.h"
#include "tasks/parts/colors.h"
#include "tasks/parts/poses.h"

namespace engram::tasks {
namespace {

Layout arc_slots() {
  Layout slots;
  for (int slot = 0; slot < COLORS; ++slot) {
    const double angle = 1.15 * std::numbers::pi * (slot - 4) / COLORS;
    slots.push_back({0.3 * real::cos(angle) + kArcX, 0.3 * real::sin(angle) + 0.018 * (slot - 4)});
  }
  return slots;
}

// Where Bunch shows the cube of a colour; it tells nothing of where the cube will stand.
Vec2 bunch_cue_position(int color) {
  const double angle = std::numbers::pi * (color - 4) / COLORS;
  return {0.22 * real::cos(angle), 0.22 * real::sin(angle) - 0.015 * (color - 4)};
}

}  // namespace

ColorCubes::ColorCubes(mjcf::Scene& scene, const ColorRecallParams& params)
    : params_(params), arc_(arc_slots()) {
  for (int color = 0; color < COLORS; ++color) {
    const auto index = static_cast<std::size_t>(color);
    mjcf::Prop cube = mjcf::cube("cube_" + std::to_string(color), CUBE_HALFSIZE,
                                 to_rgba(COLOR_MAPPING[index].rgba));
    // Apart, so that the document by itself shows all of them.
    cube.pos = {arc_[index].x(), arc_[index].y(), CUBE_HALFSIZE};
    scene.props.push_back(std::move(cube));
  }
}

void ColorCubes::bind(const Bindings& bindings) {
  engine_ = bindings;
  positions_ = bindings.memory->add<double>("positions", 2 * COLORS, "m");
}

// --- sampling ---

void ColorCubes::reset(const Episode& episode) const {
  double* positions = positions_.row(episode.env());
  if (const double* pinned = episode.pinned(kPositions)) {
    std::copy_n(pinned, 2 * COLORS, positions);
    return;
  }
  RandomStream random = episode.stream(kPositions);
  const Layout jittered = jitter_slots(arc_, random);
  for (const Vec2& place : assign_slots(jittered, random)) {
    *positions++ = place.x();
    *positions++ = place.y();
  }
}

// --- phases ---

void ColorCubes::show_cue(int env, std::span<const std::int32_t> sequence, int elapsed,
                          int cue_steps) const {
  if (params_.rule == ColorRule::kBunch) {
    if (elapsed == 0) hide_all(env, {});
    for (const std::int32_t color : sequence) place(env, color, bunch_cue_position(color));
    return;
  }
  // In a made-up snapshot the cue need not be a multiple of its items.
  const int duration = std::max(1, cue_steps / params_.SEQUENCE_LENGTH);
  const int item = std::min(elapsed / duration, params_.SEQUENCE_LENGTH - 1);
  const auto index = static_cast<std::size_t>(item);
  if (elapsed % duration == 0) hide_all(env, sequence.first(index));
  place(env, sequence[index], Vec2::Zero());
}

void ColorCubes::hide_all(int env, std::span<const std::int32_t> past) const {
  for (int color = 0; color < COLORS; ++color) {
    const bool middle = params_.rule == ColorRule::kBunch ||
                        std::find(past.begin(), past.end(), color) != past.end();
    const Vec2 at = middle ? Vec2(0, 0) : slot(env, color);
    const double pos[3] = {at.x(), at.y(), kHiddenHeight};
    engine_.state->hide_prop(env, color, pos);
  }
}

void ColorCubes::show_all(int env) const {
  for (int color = 0; color < COLORS; ++color) place(env, color, slot(env, color));
}

void ColorCubes::place(int env, int color, const Vec2& at) const {
  const double pos[3] = {at.x(), at.y(), CUBE_HALFSIZE};
  engine_.state->place_prop(env, color, pos, kUprightQuat);
}

ColorCubes::Displacement ColorCubes::displacement(int env) const {
  double sum = 0;
  double largest = 0;
  for (int color = 0; color < COLORS; ++color) {
    const double* pos = engine_.state->prop_pos_of(env, color);
    const double distance = (Vec2(pos[0], pos[1]) - slot(env, color)).norm();
    sum += distance;
    largest = std::max(largest, distance);
  }
  return {.mean = sum / COLORS, .largest = largest};
}

}  // namespace engram::tasks
