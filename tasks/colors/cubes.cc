#include "tasks/colors/cubes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/base/error.h"
#include "core/base/index.h"
#include "core/base/join.h"
#include "core/math/real_functions.h"
#include "tasks/common/overlap_guard.h"
#include "tasks/common/poses.h"
#include "tasks/common/words.h"

namespace engram::tasks {
namespace {

// Slots and colours are counted from the middle of their row.
double from_middle(int index, int count) { return index - 0.5 * (count - 1); }

// Nominal places of the action phase: on an arc around a button, or on a narrower one.
Layout slots_of(const ColorRecallParams& params) {
  const int count = params.COLORS;
  if (!params.has_button()) return nominal_slots(count);
  Layout slots;
  for (int slot = 0; slot < count; ++slot) {
    const double step = from_middle(slot, count);
    const double angle = 1.15 * std::numbers::pi * step / count;
    slots.push_back({0.3 * real::cos(angle) + kArcX, 0.3 * real::sin(angle) + 0.018 * step});
  }
  return slots;
}

// Place in which Bunch shows the cube of a colour; it says nothing about its later place.
Vec2 bunch_cue_position(int color, int count) {
  const double step = from_middle(color, count);
  const double angle = std::numbers::pi * step / count;
  return {0.22 * real::cos(angle), 0.22 * real::sin(angle) - 0.015 * step};
}

// Places in which cubes may be seen together in the cue.
Layout cue_places(const ColorRecallParams& params) {
  Layout places;
  if (params.rule != ColorRule::kBunch) {
    places.push_back(Vec2::Zero());
    return places;
  }
  for (int color = 0; color < params.COLORS; ++color) {
    places.push_back(bunch_cue_position(color, params.COLORS));
  }
  return places;
}

Layout draw_places(const Layout& slots, double half_size, RandomStream& random) {
  return assign_slots(jitter_slots(slots, half_size, random), random);
}

// The place of the button. position: gives those of the cubes.
template <class Position>
Vec2 amid(int count, const Position& position) {
  Vec2 center(BUTTON_X_SHIFT_TOWARD_ROBOT, 0);
  for (int i = 0; i < count; ++i) center += position(i) / count;
  return center;
}

// Places in which cubes or the button would be too near one another.
enum class Overlap { kNone, kCubes, kButton };

// Layouts that an episode may draw are tried, and the cue.
Overlap find_overlap(const ColorRecallParams& params, double size) {
  constexpr int kLayouts = 20;
  const double reach = params.button.shape.BUTTON_BASE_HALF_SIZE[0] + size + kMinClearance;
  const Layout slots = slots_of(params);
  const Layout cue = cue_places(params);
  const auto gap = [size](std::size_t, std::size_t, const Vec2& offset) {
    return square_clearance(size, offset);
  };
  bool apart = is_clear(cue, gap);
  bool beside = true;
  for (int i = 0; i < kLayouts; ++i) {
    RandomStream random(0, static_cast<std::uint64_t>(i), 0);
    const Layout places = draw_places(slots, size, random);
    const auto place_of = [&](int color) { return places[at(color)]; };
    const Vec2 button = amid(params.COLORS, place_of);
    const auto clear_of_button = [&](const Vec2& place) {
      return (place - button).cwiseAbs().maxCoeff() >= reach;
    };
    apart = apart && is_clear(places, gap);
    beside = beside && std::ranges::all_of(places, clear_of_button) &&
             std::ranges::all_of(cue, clear_of_button);
  }
  if (!apart) return Overlap::kCubes;
  return beside || !params.has_button() ? Overlap::kNone : Overlap::kButton;
}

// Throws Error unless all cubes stand apart from each other and from a button, in every phase.
void check_places(const ColorRecallParams& params) {
  const Overlap overlap = find_overlap(params, params.CUBE_HALFSIZE);
  if (overlap == Overlap::kNone) return;
  // The greatest size that fits, in half millimetres.
  int halves = static_cast<int>(2000 * params.CUBE_HALFSIZE);
  while (halves > 0 && find_overlap(params, halves / 2000.0) != Overlap::kNone) --halves;
  const std::string others = overlap == Overlap::kButton
                                 ? "the button, which is in the middle of their places"
                                 : "one another";
  refuse_constant("CUBE_HALFSIZE", shortest(params.CUBE_HALFSIZE),
                  "at most " + shortest(halves / 2000.0) + " allowed with COLORS " +
                      std::to_string(params.COLORS) + ": larger cubes do not stand apart from " +
                      others);
}

}  // namespace

std::string color_name(int color) { return name_color(to_rgba(COLOR_MAPPING[at(color)].rgba)); }

std::span<const std::int32_t> shuffled_colors(int count, ColorPermutation& storage,
                                              RandomStream random) {
  const auto colors = std::span(storage).first(at(count));
  random.permutation(colors);
  return colors;
}

ColorCubes::ColorCubes(mjcf::Scene& scene, const ColorRecallParams& params, VariableHandle places)
    : params_(params), places_(places), slots_(slots_of(params)) {
  check_places(params);
  for (int color = 0; color < count(); ++color) {
    const std::size_t index = at(color);
    mjcf::Prop cube = mjcf::cube("cube_" + std::to_string(color), params.CUBE_HALFSIZE,
                                 to_rgba(COLOR_MAPPING[index].rgba));
    // Apart, so that the document by itself shows all of them.
    cube.pos = {slots_[index].x(), slots_[index].y(), params.CUBE_HALFSIZE};
    scene.props.push_back(std::move(cube));
  }
}

void ColorCubes::bind(const Bindings& bindings) {
  engine_ = bindings;
  positions_ = bindings.memory->add<double>("positions", 2 * count(), "m");
}

// --- sampling ---

void ColorCubes::reset(const Episode& episode) const {
  double* positions = positions_.row(episode.env());
  if (const double* pinned = places_.pinned(episode)) {
    std::copy_n(pinned, 2 * count(), positions);
    return;
  }
  RandomStream random = places_.stream(episode);
  for (const Vec2& place : draw_places(slots_, params_.CUBE_HALFSIZE, random)) {
    *positions++ = place.x();
    *positions++ = place.y();
  }
}

Vec2 ColorCubes::button_center(int env) const {
  return amid(count(), [&](int color) { return slot(env, color); });
}

// --- phases ---

void ColorCubes::show_cue(int env, std::span<const std::int32_t> sequence, int elapsed,
                          int cue_steps) const {
  if (params_.rule == ColorRule::kBunch) {
    if (elapsed == 0) hide_all(env, {});
    for (const std::int32_t color : sequence) place(env, color, bunch_cue_position(color, count()));
    return;
  }
  const std::size_t index = at(shown(elapsed, cue_steps) - 1);
  if (elapsed % item_steps(cue_steps) == 0) hide_all(env, sequence.first(index));
  place(env, sequence[index], Vec2::Zero());
}

// In a made-up snapshot the cue need not be a multiple of its items.
int ColorCubes::item_steps(int cue_steps) const {
  return std::max(1, cue_steps / params_.SEQUENCE_LENGTH);
}

int ColorCubes::shown(int elapsed, int cue_steps) const {
  if (params_.rule == ColorRule::kBunch) return params_.SEQUENCE_LENGTH;
  return std::min(elapsed / item_steps(cue_steps) + 1, params_.SEQUENCE_LENGTH);
}

void ColorCubes::hide_all(int env, std::span<const std::int32_t> past) const {
  for (int color = 0; color < count(); ++color) {
    const bool moved =
        params_.has_button() && std::find(past.begin(), past.end(), color) != past.end();
    const bool middle = params_.rule == ColorRule::kBunch || moved;
    const Vec2 at = middle ? Vec2(0, 0) : slot(env, color);
    const double pos[3] = {at.x(), at.y(), kHiddenHeight};
    engine_.state->hide_prop(env, color, pos);
  }
}

void ColorCubes::show_all(int env) const {
  for (int color = 0; color < count(); ++color) place(env, color, slot(env, color));
}

void ColorCubes::place(int env, int color, const Vec2& at) const {
  const double pos[3] = {at.x(), at.y(), params_.CUBE_HALFSIZE};
  engine_.state->place_prop(env, color, pos, kUprightQuat);
}

ColorCubes::Displacement ColorCubes::displacement(int env) const {
  double sum = 0;
  double largest = 0;
  for (int color = 0; color < count(); ++color) {
    const double* pos = engine_.state->prop_pos_of(env, color);
    const double distance = (Vec2(pos[0], pos[1]) - slot(env, color)).norm();
    sum += distance;
    largest = std::max(largest, distance);
  }
  return {.mean = sum / count(), .largest = largest};
}

}  // namespace engram::tasks
