// Search for outputs after the cue that reveal its content.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/batch/queries.h"
#include "protocol/make/make.h"
#include "tests/differing_pixels.h"
#include "tests/env_helpers.h"

namespace engram::test {

// Two sets of values of a hidden draw, as different as possible.
inline std::vector<double> hidden_values(const RandomVariable& draw, bool other) {
  const auto width = static_cast<std::size_t>(draw.width);
  std::vector<double> values(width, other ? draw.high : draw.low);
  for (std::size_t i = 0; draw.distinct && i < width; ++i) {
    values[i] += (other ? -1.0 : 1.0) * static_cast<double>(i);
  }
  return values;
}

// A batch of one environment in which that draw has the one or the other values. All else is drawn
// as ever.
inline std::unique_ptr<Batch> make_hiding(const std::string& id, const ConstantTable& constants,
                                          std::uint64_t seed, const RandomVariable& draw,
                                          bool second,
                                          std::vector<PerturbationLevel> perturbations = {}) {
  MakeOptions options{{.seed = seed,
                       .threads = 1,
                       .auto_reset = AutoReset::kOff,
                       .perturbations = std::move(perturbations)},
                      constants};
  options.reward_mode = RewardMode::kSparse;  // dense ones measure the way to the hidden goal
  auto batch = make(id, options);
  const std::vector<Pin> pins = {{draw.name, hidden_values(draw, second)}};
  batch->reset({.mask = {}, .seeds = {}, .pins = &pins});
  return batch;
}

inline std::optional<RandomVariable> draw_named(const TaskInfo& info, std::string_view name) {
  for (const RandomVariable& draw : info.random_variables) {
    if (draw.name == name) return draw;
  }
  return std::nullopt;
}

// True if an output may reveal what is hidden: docs/evaluation.md names those infos.
inline bool is_closed(const Batch& batch, const std::string& output) {
  return output != "instruction" && batch.output(output).field->privileged;
}

// The outputs of the first environment that differ between two batches, in a bit.
inline std::vector<std::string> differing_outputs(const Batch& one, const Batch& other) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < columns_of(one).size(); ++i) {
    const std::string& name = columns_of(one)[i].field->name;
    const ColumnView a = one.output(name);
    const auto bytes = static_cast<std::size_t>(a.field->width) * size_of(a.field->dtype);
    if (!std::equal(a.row(0), a.row(0) + bytes, other.output(name).row(0))) names.push_back(name);
  }
  if (Queries(one).instruction(0) != Queries(other).instruction(0))
    names.emplace_back("instruction");
  return names;
}

// Outputs that nothing may reveal.
inline std::vector<std::string> leaking_outputs(const Batch& one, const Batch& other) {
  std::vector<std::string> names = differing_outputs(one, other);
  std::erase_if(names, [&one](const std::string& name) { return is_closed(one, name); });
  return names;
}

// How closely images are compared.
struct LeakCheck {
  int enough = 10;   // pixels in which a cue has to differ
  int closely = 60;  // control steps after the cue of which all are looked at, then one in fifty
  // Who moves the robot once the cue is over; `one` decides for both. kZero: it rests.
  Policy policy = Policy::kZero;
  std::vector<PerturbationLevel> perturbations = {};
};

// A moment in which what is hidden shows: the cue, and the flashes of tasks that show it at a time
// of the robot's choosing.
inline bool shows(const Batch& batch) {
  for (const char* name : {"flash_active", "lit"}) {
    for (const ColumnStore* store : {&columns_of(batch), &memory_of(batch)}) {
      const ColumnView view = store->find(name);
      if (view.field != nullptr) return *row<std::uint8_t>(view, 0) != 0;
    }
  }
  return batch.state().elapsed[0] < Queries(batch).cue_end(0);
}

inline bool has_answered(const Batch& batch) {
  const ColumnView view = columns_of(batch).find("answered");
  return view.field != nullptr && *row<std::uint8_t>(view, 0) != 0;
}

// Plays two episodes that differ in what is hidden alone, until the robot has answered. It rests
// while the cue shows; then `policy` moves it, and `one` decides for both. look(shown): called in
// every step before the robot acts; whether what is hidden shows in it.
template <class Look>
void play_unanswered(Batch& one, Batch& other, Policy policy, Look&& look) {
  const std::vector<float> rest = zeros(one);
  bool cue_over = false;
  while (one.state().finished[0] == 0 && other.state().finished[0] == 0) {
    if (has_answered(one) || has_answered(other)) return;
    const bool shown = shows(one) || shows(other);
    cue_over |= !shown;
    look(shown);
    const bool rests = policy == Policy::kZero || !cue_over;
    const std::vector<float> actions = rests ? rest : act(one, policy);
    one.step(actions);
    other.step(actions);
  }
}

// Plays two episodes that differ in what is hidden alone. Outside the moments that show it, no
// camera sees a difference, and no info has one, until the robot has answered. People may be
// shown where the goal is.
inline void compare_images(const std::string& id, Batch& one, Batch& other,
                           const LeakCheck& check) {
  const bool goal_for_people = require_entry(id).definition->expectations.goal_for_people;
  ImagePair images(one, other);
  std::vector<float> rest = zeros(one);
  int since_cue = 0;
  int seen = 0;
  const bool timed = Queries(one).cue_end(0) < one.info().horizon;
  while (one.state().finished[0] == 0 && other.state().finished[0] == 0) {
    if (shows(one) || shows(other)) {
      for (const char* sensor : {"base_camera", "hand_camera"}) {
        if (seen < check.enough) seen = std::max(seen, images.differing_pixels(sensor));
      }
    } else if (since_cue++ <= check.closely || since_cue % 50 == 0) {
      for (const char* camera : {"base_camera", "hand_camera", "render_camera"}) {
        if (goal_for_people && camera == std::string_view("render_camera")) continue;
        REQUIRE(images.differing_pixels(camera) == 0);
      }
    }
    if (has_answered(one) || has_answered(other)) break;
    if (!shows(one) && !shows(other)) REQUIRE(leaking_outputs(one, other).empty());
    const bool rests = check.policy == Policy::kZero || (timed && since_cue == 0);
    const std::vector<float> actions = rests ? rest : act(one, check.policy);
    one.step(actions);
    other.step(actions);
  }
  // What depends on the robot may never have been shown.
  if (timed) CHECK(seen >= check.enough);
}

// Checks a task's hidden draw, if it has one that can differ.
inline void check_leaks(const std::string& id, const ConstantTable& constants, std::uint64_t seed,
                        const LeakCheck& check = {}) {
  const std::unique_ptr<Task> task = make_task(id, constants);
  const std::optional<RandomVariable> draw = draw_named(task->info(), task->info().hidden_variable);
  if (!draw || hidden_values(*draw, false) == hidden_values(*draw, true)) return;
  const auto one = make_hiding(id, constants, seed, *draw, false, check.perturbations);
  const auto other = make_hiding(id, constants, seed, *draw, true, check.perturbations);
  compare_images(id, *one, *other, check);
}

}  // namespace engram::test
