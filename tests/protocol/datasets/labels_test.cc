#include "protocol/datasets/labels.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/batch/queries.h"
#include "core/batch/scripted_policy.h"
#include "protocol/datasets/recorder.h"
#include "protocol/io/files.h"
#include "tests/env_helpers.h"
#include "tests/temporary_folder.h"

namespace engram::test {
namespace {

std::unique_ptr<Batch> labelled(const std::string& id, std::uint64_t seed,
                                std::vector<Pin> pins = {}, bool labels = true) {
  MakeOptions options = demonstration_options({.labels = labels});
  options.threads = 1;
  options.seed = seed;
  options.pins = std::move(pins);
  auto batch = make(id, options);
  batch->reset();
  return batch;
}

// Plays the oracle to the end; watch(t) is called with every frame.
template <class Watch>
EpisodeLabels record(Batch& batch, Watch&& watch) {
  LabelRecorder recorder;
  recorder.start(batch, 0);
  for (int t = 0; (batch.outputs().terminated[0] | batch.outputs().truncated[0]) == 0; ++t) {
    recorder.before_step(batch, 0);
    watch(t, recorder.labels());
    test::step(batch, Policy::kOracle);
    recorder.after_step(batch, 0);
  }
  return recorder.labels();
}

// Words of a subtask as they are at a frame.
std::string words_at(const EpisodeLabels& labels, std::size_t t) {
  std::string words;
  for (std::size_t i = 0; i < labels.plan.size(); ++i) {
    const bool holds = labels.plan_step[i] <= static_cast<std::int32_t>(t);
    if (holds && labels.plan_index[i] == labels.subtask_index[t]) words = labels.plan[i];
  }
  return words;
}

// Pixel and depth, in mm, of a point in the world.
Eigen::Vector3d project(const Batch& batch, const char* camera, const Eigen::Vector3d& point) {
  std::vector<float> extrinsic(12);
  std::vector<float> intrinsic(9);
  Queries(batch).camera_params(
      camera, 128, 128, {.extrinsic_cv = extrinsic, .cam2world_gl = {}, .intrinsic_cv = intrinsic});
  Eigen::Vector3d seen;
  for (int i = 0; i < 3; ++i) {
    seen[i] = extrinsic[static_cast<std::size_t>(4 * i + 3)];
    for (int k = 0; k < 3; ++k)
      seen[i] += extrinsic[static_cast<std::size_t>(4 * i + k)] * point[k];
  }
  return {intrinsic[0] * seen.x() / seen.z() + intrinsic[2],
          intrinsic[4] * seen.y() / seen.z() + intrinsic[5], 1000 * seen.z()};
}

}  // namespace

TEST_CASE("Labels: keyframes at new subtasks and at the answer", "[labels][demonstrations]") {
  for (const char* id : {"RememberColor3-VLA-v0", "BlinkCountButtonPressEasy-VLA-v0",
                         "ShellGameShuffleTouch-VLA-v0", "SeqOfColors3-VLA-v0"}) {
    INFO(id);
    const auto batch = labelled(id, 11);
    const EpisodeLabels labels = record(*batch, [](int, const EpisodeLabels&) {});
    const std::size_t steps = labels.subtask_index.size();
    REQUIRE(steps > 5);
    REQUIRE(labels.answered.size() == steps);
    int keyframes = 0;
    for (std::size_t t = 0; t < steps; ++t) {
      INFO("frame " << t);
      const bool begins = t == 0 || words_at(labels, t) != words_at(labels, t - 1);
      const bool answers = labels.answered[t] != 0 && (t == 0 || labels.answered[t - 1] == 0);
      CHECK((labels.is_keyframe[t] != 0) == (begins || answers));
      keyframes += labels.is_keyframe[t];
      if (t > 0) CHECK(labels.progress[t] >= labels.progress[t - 1]);
    }
    CHECK(keyframes >= 4);
    CHECK(labels.progress.front() == 0);
    CHECK(labels.progress.back() > 0.5F);
    CHECK(labels.progress.back() < 1);
    CHECK(labels.answered.back() == 1);
    CHECK(labels.first_answer_correct.back() == 1);
    CHECK(labels.paraphrases.size() >= 10);
  }
}

TEST_CASE("Labels: words are written once, with the frame from which they hold",
          "[labels][demonstrations]") {
  const auto batch = labelled("BlinkCountButtonPressEasy-VLA-v0", 3, {{"target_blinks", {2}}});
  const EpisodeLabels labels = record(*batch, [](int, const EpisodeLabels&) {});
  const int* starts = test::row<std::int32_t>(memory_of(*batch).find("blink_start"), 0);
  const int acts = *test::row<std::int32_t>(memory_of(*batch).find("cue_steps"), 0);
  CHECK(labels.memory == std::vector<std::string>{"the lamp has blinked so far 1 time",
                                                  "the lamp has blinked so far 2 times",
                                                  "the lamp blinked 2 times"});
  CHECK(labels.memory_step == std::vector<std::int32_t>{starts[0], starts[1], acts});
  CHECK(labels.plan_index == std::vector<std::int32_t>{0, 1, 2, 0, 1, 2, 3});
  CHECK(labels.plan_step == std::vector<std::int32_t>{0, 0, 0, acts, acts, acts, acts});
  CHECK(labels.plan[1] == "press the red button as often as the lamp blinked");
  CHECK(labels.plan[5] == "press the red button, press 2 of 2");
}

TEST_CASE("Labels: boxes and points are where the cameras have the object",
          "[labels][demonstrations]") {
  const auto batch = labelled("RememberColor9-VLA-v0", 21, {{"target", {2}}, {"cue_steps", {3}}});
  int seen = 0;
  const char* const cameras[] = {"base_camera", "hand_camera"};
  const EpisodeLabels labels = record(*batch, [&](int t, const EpisodeLabels& so_far) {
    INFO("frame " << t);
    const int object = so_far.object_index.back();
    for (std::size_t camera = 0; camera < 2; ++camera) {
      const std::int32_t* box = &so_far.object_box[static_cast<std::size_t>(8 * t) + 4 * camera];
      const std::int32_t* point =
          &so_far.object_point[static_cast<std::size_t>(6 * t) + 3 * camera];
      if (object < 0 || box[0] < 0) {
        CHECK(std::all_of(box, box + 4, [](int value) { return value == -1; }));
        CHECK(std::all_of(point, point + 3, [](int value) { return value == -1; }));
        continue;
      }
      CHECK((box[0] < box[2] && box[1] < box[3] && box[2] <= 128 && box[3] <= 128));
      CHECK((point[0] >= box[0] && point[0] < box[2] && point[1] >= box[1] && point[1] < box[3]));
      const bool whole = box[0] > 0 && box[1] > 0 && box[2] < 128 && box[3] < 128;
      if (camera != 0 || !whole) continue;
      ++seen;
      const Eigen::Vector3d middle =
          Eigen::Map<const Eigen::Vector3d>(batch->state().prop_pos_of(0, object));
      const Eigen::Vector3d pixel = project(*batch, cameras[camera], middle);
      CHECK((pixel.x() > box[0] - 1 && pixel.x() < box[2] + 1));
      CHECK((pixel.y() > box[1] - 1 && pixel.y() < box[3] + 1));
      CHECK(std::abs(pixel.z() - point[2]) < 45);  // a cube of 4 cm
    }
  });
  CHECK(seen > 5);
  CHECK(labels.object_names[2] == "cube_2");
  CHECK(labels.object_index.front() == 2);
}

// What is not listed as privileged tells nothing of what differs between two episodes.
TEST_CASE("Labels: every array is privileged, or tells nothing hidden",
          "[labels][demonstrations]") {
  const auto played = [](double color) {
    const auto batch = labelled("ShellGameColorLampTouch-VLA-v0", 4, {{"target_color", {color}}});
    return record(*batch, [](int, const EpisodeLabels&) {});
  };
  const EpisodeLabels red = played(0);
  const EpisodeLabels blue = played(2);
  CHECK(red.plan != blue.plan);
  CHECK(red.paraphrases == blue.paraphrases);
  const auto task = make_task("ShellGameColorLampTouch-VLA-v0");
  std::vector<std::string> listed = privileged_labels(task->info());
  for (const std::string& name : open_labels()) listed.push_back(name);
  std::vector<std::string> written;
  const LabelArrays arrays(red);
  for (const NpyArray& array : arrays.arrays()) written.push_back(array.name);
  CHECK(written == listed);
}

TEST_CASE("Labels: a file has them beside arrays that stay the same", "[labels][demonstrations]") {
  for (const char* id : {"RememberColor3-VLA-v0", "InterceptSlow-VLA-v0"}) {
    INFO(id);
    const TemporaryFolder folder;
    EpisodeLabels expected;
    const auto file_of = [&](bool labels, const char* name) {
      const auto batch = labelled(id, 5, {}, labels);
      DemonstrationRecorder recorder({.labels = labels});
      recorder.start(*batch, 0);
      std::optional<LabelRecorder> alone;
      if (labels) alone.emplace().start(*batch, 0);
      std::vector<float> actions(7);
      while ((batch->outputs().terminated[0] | batch->outputs().truncated[0]) == 0) {
        ScriptedPolicy(*batch, Policy::kOracle).act(actions);
        recorder.before_step(*batch, 0, actions);
        if (alone) alone->before_step(*batch, 0);
        batch->step(actions);
        recorder.after_step(*batch, 0);
        if (alone) alone->after_step(*batch, 0);
      }
      if (alone) expected = alone->labels();
      const Demonstration demonstration = recorder.finish();
      REQUIRE(demonstration.success);
      write_file(folder.path() / name, demonstration.file);
      return NpzFile(folder.path() / name);
    };
    const NpzFile plain = file_of(false, "plain.npz");
    const NpzFile with = file_of(true, "with.npz");
    const std::int64_t steps = plain.shape("reward", NpyType::kFloat32)[0];
    const std::int64_t frames[] = {steps, 128, 128, 6};
    const std::int64_t sevens[] = {steps, 7};
    const std::int64_t singles[] = {steps};
    CHECK(plain.read("rgb", NpyType::kUint8, frames) == with.read("rgb", NpyType::kUint8, frames));
    for (const char* name : {"proprio", "action"}) {
      CHECK(plain.read(name, NpyType::kFloat32, sevens) ==
            with.read(name, NpyType::kFloat32, sevens));
    }
    CHECK(plain.read("reward", NpyType::kFloat32, singles) ==
          with.read("reward", NpyType::kFloat32, singles));

    const auto task = make_task(id);
    const bool answers = !task->info().answer.empty();
    const std::vector<std::string> names = privileged_labels(task->info());
    CHECK((std::find(names.begin(), names.end(), "first_answer") != names.end()) == answers);
    CHECK(with.shape("subtask_index", NpyType::kInt32) == std::vector<std::int64_t>{steps});
    CHECK(with.shape("is_keyframe", NpyType::kBool) == std::vector<std::int64_t>{steps});
    CHECK(with.shape("progress", NpyType::kFloat32) == std::vector<std::int64_t>{steps});
    CHECK(with.shape("object_box", NpyType::kInt32) == std::vector<std::int64_t>{steps, 2, 4});
    CHECK(with.shape("object_point", NpyType::kInt32) == std::vector<std::int64_t>{steps, 2, 3});
    const std::int64_t boxes[] = {steps, 2, 4};
    const auto same = [](const auto& values, const std::vector<std::byte>& bytes) {
      return std::ranges::equal(bytes_of(values), bytes);
    };
    CHECK(same(expected.subtask_index, with.read("subtask_index", NpyType::kInt32, singles)));
    CHECK(same(expected.is_keyframe, with.read("is_keyframe", NpyType::kBool, singles)));
    CHECK(same(expected.progress, with.read("progress", NpyType::kFloat32, singles)));
    CHECK(same(expected.object_box, with.read("object_box", NpyType::kInt32, boxes)));
    if (answers) CHECK(with.shape("first_answer", NpyType::kInt32)[0] == steps);
    if (!answers) CHECK_THROWS(with.shape("first_answer", NpyType::kInt32));
    CHECK_THROWS(plain.shape("subtask_index", NpyType::kInt32));
  }
}

}  // namespace engram::test
