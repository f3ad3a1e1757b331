// What every task keeps to, apart from how it is played: its horizon, its instruction, the
// description of its values, and that what is hidden is not there.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "core/batch/queries.h"
#include "core/batch/scene_renderer.h"
#include "core/batch/snapshot.h"
#include "engram/engram_c.h"
#include "protocol/make/make.h"
#include "tasks/family_samples.h"
#include "tests/api/c_api_fixture.h"
#include "tests/env_helpers.h"
#include "tests/tasks/spectator.h"

namespace engram {
namespace {

using nlohmann::json, test::make_env, test::make_running, test::row;

constexpr std::array kAutoResets = {AutoReset::kNextStep, AutoReset::kSameStep, AutoReset::kOff};

// --- horizons ---

// The step that ends an episode in which nobody does anything: TimedTransfer fails when its window
// is over, all others run to the horizon.
int last_step_of_idlers(Batch& batch) {
  if (!batch.info().family.starts_with("TimedTransfer")) return batch.info().horizon;
  const float delay = *row<float>(batch.output("oracle_info"), 0);
  return 2 + static_cast<int>(static_cast<double>(delay) * 1.05) + 1;  // signal_step is pinned
}

void check_horizon(const std::string& id, AutoReset mode) {
  INFO(id << ", auto-reset " << static_cast<int>(mode));
  MakeOptions options;
  options.num_envs = 2;
  options.auto_reset = mode;
  options.substeps = 0;  // physics has no say in this
  options.terminate_on_success = false;
  options.obs_mode = ObsMode::kNone;
  if (id.starts_with("TimedTransfer")) options.pins = {{"signal_step", {2}}};
  const auto batch = make_running(id, options);
  const int last = last_step_of_idlers(*batch);
  const bool fails = last < batch->info().horizon;
  const std::vector<float> rest = test::zeros(*batch);
  for (int step = 1; step <= last; ++step) {
    batch->step(rest);
    for (const std::size_t i : {0U, 1U}) {
      const bool over = batch->outputs().truncated[i] != 0 || batch->outputs().terminated[i] != 0;
      if (over != (step == last)) FAIL("over: " << over << " in step " << step);
    }
  }
  CHECK((batch->outputs().terminated[0] != 0) == fails);
  CHECK((batch->outputs().truncated[0] != 0) != fails);
  CHECK((batch->outputs().final_mask[0] != 0) == (mode == AutoReset::kSameStep));
  const int elapsed = *row<std::int32_t>(batch->output("elapsed_steps"), 0);
  CHECK(elapsed == (mode == AutoReset::kSameStep ? 0 : last));
  batch->step(rest);
  const int next = *row<std::int32_t>(batch->output("elapsed_steps"), 0);
  CHECK(next == (mode == AutoReset::kNextStep ? 0 : mode == AutoReset::kSameStep ? 1 : last));
  CHECK((batch->outputs().truncated[0] != 0) == (mode == AutoReset::kOff && !fails));
}

TEST_CASE("Every task is truncated exactly at its horizon in all auto-reset modes",
          "[properties]") {
  for (const std::string& id : test::implemented_ids()) {
    for (const AutoReset mode : kAutoResets) check_horizon(id, mode);
  }
}

// --- what is hidden ---

// Puts every hidden prop of an environment where it would be in the way and in the image.
int drag_hidden_props_into_view(const State& state, int env) {
  int dragged = 0;
  for (int prop = 0; prop < state.num_props; ++prop) {
    if (state.status_of(env, prop) != PropStatus::kHidden) continue;
    const double* tcp = state.tcp_pos.row(env);
    double* pos = state.prop_pos_of(env, prop);
    for (int i = 0; i < 3; ++i) pos[i] = tcp[i];
    ++dragged;
  }
  return dragged;
}

std::vector<std::uint8_t> image(Batch& batch, const char* camera) {
  constexpr int kSide = 48;
  std::vector<std::uint8_t> rgb(kSide * kSide * 3);
  SceneRenderer(batch).render(0, camera, kSide, kSide, rgb);
  return rgb;
}

// Robot and visible props, joint by joint and pose by pose.
std::vector<double> bodies(const State& state) {
  std::vector<double> values(state.qpos.row(0), state.qpos.row(0) + kRobotJoints);
  values.insert(values.end(), state.qvel.row(0), state.qvel.row(0) + kRobotJoints);
  for (int prop = 0; prop < state.num_props; ++prop) {
    if (state.status_of(0, prop) == PropStatus::kHidden) continue;
    values.insert(values.end(), state.prop_pos_of(0, prop), state.prop_pos_of(0, prop) + 3);
    values.insert(values.end(), state.prop_quat_of(0, prop), state.prop_quat_of(0, prop) + 4);
  }
  return values;
}

// Two runs of the same steps, in one of which the hidden props stand in the hand: they must neither
// be felt nor seen. Returns how many were hidden in all.
int compare_with_dragged(const std::string& id, bool sleep) {
  INFO(id << ", sleep " << sleep);
  MakeOptions options;
  options.auto_reset = AutoReset::kOff;
  options.sleep = sleep;
  const auto plain = make(id, options);
  const auto other = make(id, options);
  plain->reset();
  other->reset();
  int hidden = 0;
  for (int step = 0; step < 12; ++step) {
    Snapshotter(*other).restore(Snapshotter(*plain).save());
    const int dragged = drag_hidden_props_into_view(other->state(), 0);
    hidden += dragged;
    if (dragged > 0 && step % 4 == 0) {
      for (const char* camera : {"base_camera", "hand_camera"}) {
        REQUIRE((image(*plain, camera) == image(*other, camera)));
      }
    }
    const std::vector<float> actions = test::act(*plain, Policy::kRandom);
    plain->step(actions);
    other->step(actions);
    REQUIRE(bodies(plain->state()) == bodies(other->state()));
  }
  return hidden;
}

TEST_CASE("Hidden props are neither felt nor seen", "[properties]") {
  for (const std::string& id : one_of_each_family()) {
    const int hidden = compare_with_dragged(id, true);
    INFO(id);
    CHECK((hidden > 0) == require_entry(id).definition->expectations.hides);
  }
}

TEST_CASE("Hidden props of all tasks are neither felt nor seen, with and without sleep",
          "[properties][long]") {
  for (const std::string& id : test::implemented_ids()) {
    for (const bool sleep : {true, false}) {
      const int hidden = compare_with_dragged(id, sleep);
      INFO(id);
      CHECK((hidden > 0) == require_entry(id).definition->expectations.hides);
    }
  }
}

// --- descriptions ---

// Rotate's instruction names the angle, rounded half to even; all others are those
// of the registry, the same in every episode.
std::string instruction_of(const Batch& batch, int index) {
  const RegistryEntry& entry = require_entry(batch.info().id);
  std::string text(entry.instruction);
  const std::string gap = "{angle_deg}";
  if (const std::size_t at = text.find(gap); at != std::string::npos) {
    const float degrees =
        *row<float>(batch.output("task_cue"), index) * (180.0F / 3.14159265358979F);
    text.replace(at, gap.size(), std::to_string(std::lrint(degrees)));
  }
  return text;
}

void check_fields(const json& described, const ColumnStore& columns) {
  REQUIRE(described.size() == columns.size());
  std::set<std::string> names;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const Field& field = *columns[i].field;
    INFO(field.name);
    CHECK(described[i]["name"] == field.name);
    CHECK(described[i]["width"] == field.width);
    CHECK(described[i]["dtype"] == dtype_name(field.dtype));
    CHECK(names.insert(field.name).second);
  }
}

// Positions in the row follow one upon another, and the last one ends it.
int checked_row(const json& fields) {
  int offset = 0;
  for (const json& field : fields) {
    CHECK(field["offset"] == offset);
    offset += field["width"].get<int>();
  }
  return offset;
}

TEST_CASE("Descriptions of every task fit its registry entry and its values", "[properties]") {
  const json listed = json::parse(engram_list_json());
  std::size_t index = 0;
  for (const std::string& id : test::implemented_ids()) {
    INFO(id);
    MakeOptions options;
    options.num_envs = 8;
    const auto batch = make_running(id, options);
    const TaskInfo& info = batch->info();
    const RegistryEntry& entry = require_entry(id);
    engram_options c_options = test::default_options(1);
    const test::BatchHandle handle = test::make_batch(c_options, id.c_str());
    const json task = json::parse(engram_describe_json(handle.get()));

    for (int i = 0; i < options.num_envs; ++i) {
      CHECK(Queries(*batch).instruction(i) == instruction_of(*batch, i));
    }
    for (const json& text : {task, listed[index]}) {
      CHECK(text["id"] == id);
      CHECK(text["family"] == entry.family);
      CHECK(text["split"] == split_name(entry.split));
      CHECK(text["memory_type"] == entry.memory_type);
      CHECK(text["horizon"] == entry.horizon);
      CHECK(text["canonical"] == entry.canonical);
      CHECK(text["instruction"] == entry.instruction);
      CHECK(text["candidates"] == info.candidates);
      CHECK(text["state_dim"] == batch->state_dim());
      CHECK(text["action_dim"] == batch->action_dim());
    }
    ++index;
    CHECK(task["success_reward"] == info.success_reward);
    CHECK(checked_row(task["state_fields"]) == batch->state_dim());
    check_fields(task["outputs"], test::columns_of(*batch));
    CHECK(task["draws"].size() == Queries(*batch).random_variables().size());
    CHECK(task["props"].size() == batch->physics_model().props().size());
    CHECK(task["reward_terms"].size() == info.reward_terms.size());

    // What policies are given has the width of its description, and the values that belong there.
    const auto width = [&](const char* name) {
      const ColumnView view = test::columns_of(*batch).find(name);
      return view.field == nullptr ? 0 : view.field->width;
    };
    CHECK(width("observation") == batch->state_dim());
    CHECK(width("oracle_info") == info.oracle_dim);
    // Other families keep their cue in info alone.
    CHECK(info.task_cue_dim == (id.starts_with("Rotate") ? 1 : 0));
    if (info.task_cue_dim > 0) CHECK(width("task_cue") == info.task_cue_dim);
    CHECK(width("reward_dict") == static_cast<int>(info.reward_terms.size()));
    CHECK(batch->outputs().observation.size() == 8U * static_cast<std::size_t>(batch->state_dim()));
    CHECK(std::ranges::all_of(batch->outputs().observation,
                              [](float value) { return std::isfinite(value); }));
    const test::Spectator scene(*batch, 3);
    for (int i = 0; i < 3; ++i) {
      CHECK(scene.observed("tcp_pose")[i] == static_cast<float>(scene.tcp()[i]));
    }
    for (int i = 0; i < info.oracle_dim; ++i) {
      const bool given =
          std::ranges::any_of(Queries(*batch).state_fields(),
                              [](const Field& field) { return field.name == "oracle_info"; });
      REQUIRE((given || id.find("OfColors") != std::string::npos));
      CHECK(static_cast<double>(scene.observed("oracle_info")[i]) == scene.info("oracle_info", i));
    }
  }
  CHECK(index == listed.size());
}

// --- doing nothing, or anything ---

// The most successes that chance gives in `episodes` but once in 10,000 times.
int max_by_chance(int episodes, double chance) {
  double below = 0;
  for (int k = 0; k <= episodes; ++k) {
    below +=
        std::exp(std::lgamma(episodes + 1) - std::lgamma(k + 1) - std::lgamma(episodes - k + 1) +
                 k * std::log(chance) + (episodes - k) * std::log1p(-chance));
    if (below >= 1 - 1e-4) return k;
  }
  return episodes;
}

void check_chance(const std::vector<std::string>& ids, int episodes) {
  for (const std::string& id : ids) {
    if (require_entry(id).horizon > 100) continue;
    MakeOptions options;
    options.num_envs = episodes;
    options.auto_reset = AutoReset::kOff;
    const auto batch = make_env(id, options);
    for (const Policy policy : {Policy::kZero, Policy::kRandom}) {
      batch->reset();
      for (int step = 0; step < batch->info().horizon; ++step) test::step(*batch, policy);
      int successes = 0;
      for (int i = 0; i < episodes; ++i) {
        successes += *row<std::uint8_t>(batch->output("success_once"), i);
      }
      INFO(id << ", policy " << static_cast<int>(policy));
      // Untouched balls roll into the goal now and then; all else stays where it is.
      const double idle = id == "InterceptSlow-v0"          ? 0.095
                          : id.starts_with("InterceptSlow") ? 0.0056
                                                            : 1e-4;
      const double chance = policy == Policy::kZero ? idle : batch->info().chance();
      CHECK(successes <= max_by_chance(episodes, std::min(chance, 1 - 1e-9)));
    }
  }
}

TEST_CASE("The most successes by chance are those of the binomial distribution", "[properties]") {
  CHECK(max_by_chance(10, 0.5) == 10);
  CHECK(max_by_chance(200, 0.01) == 9);
}

TEST_CASE("Who does nothing, or anything, wins short tasks no more often than by chance",
          "[properties]") {
  check_chance(short_ids(), 100);
}

TEST_CASE("Who does nothing, or anything, wins no task more often than by chance",
          "[properties][long]") {
  check_chance(test::implemented_ids(), 300);
}

}  // namespace
}  // namespace engram
