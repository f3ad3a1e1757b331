#include "core/perturb/perturbation.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "core/base/error.h"
#include "core/batch/queries.h"
#include "core/batch/scene_renderer.h"
#include "core/batch/snapshot.h"
#include "protocol/make/make.h"
#include "tasks/common/paraphrases.h"
#include "tests/env_helpers.h"
#include "tests/render/has_egl.h"

namespace engram {
namespace {

using Catch::Contains;
using enum PerturbationAxis;

constexpr const char* kId = "RememberColor5-VLA-v0";

std::vector<PerturbationLevel> all_axes(double level) {
  std::vector<PerturbationLevel> levels;
  for (std::size_t i = 0; i < kPerturbationAxes; ++i) {
    levels.push_back({static_cast<PerturbationAxis>(i), level});
  }
  return levels;
}

MakeOptions with(std::vector<PerturbationLevel> levels, ObsMode mode = ObsMode::kState,
                 int num_envs = 3) {
  MakeOptions options;
  options.num_envs = num_envs;
  options.obs_mode = mode;
  options.threads = 1;
  options.perturbations = std::move(levels);
  return options;
}

std::vector<std::uint8_t> image(const Batch& batch, int index,
                                std::string_view camera = "base_camera") {
  std::vector<std::uint8_t> rgb(3 * 64 * 64);
  SceneRenderer(batch).render(index, camera, 64, 64, rgb);
  return rgb;
}

// Everything that environments show over some steps of the oracle.
test::Bytes shown(Batch& batch, int steps = 12) {
  test::Bytes bytes;
  const auto add = [&] {
    for (int i = 0; i < batch.num_envs(); ++i) test::append_row(test::columns_of(batch), i, bytes);
    const auto rgb = std::as_bytes(batch.images().rgb);
    bytes.insert(bytes.end(), rgb.begin(), rgb.end());
  };
  batch.reset();
  add();
  for (int i = 0; i < steps; ++i) {
    test::step(batch, Policy::kOracle);
    add();
  }
  return bytes;
}

TEST_CASE("Level 0 changes no bit and adds no draw", "[perturbation]") {
  for (const ObsMode mode : {ObsMode::kState, ObsMode::kRgb}) {
    const auto usual = make(kId, with({}, mode));
    const auto none = make(kId, with(all_axes(0), mode));
    CHECK(shown(*none) == shown(*usual));
    CHECK(Queries(*none).random_variables().size() == Queries(*usual).random_variables().size());
    CHECK(Snapshotter(*none).save(0) == Snapshotter(*usual).save(0));
  }
}

TEST_CASE("Levels that are out of range or given twice are refused, and unknown axes",
          "[perturbation]") {
  CHECK_THROWS_WITH(make(kId, with({{kLight, 1.5}})),
                    Contains("light") && Contains("1.5 given, 0 to 1 allowed"));
  CHECK_THROWS_WITH(make(kId, with({{kLight, std::nan("")}})), Contains("0 to 1 allowed"));
  CHECK_THROWS_WITH(make(kId, with({{kLight, 0.5}, {kLight, 0.5}})), Contains("given twice"));
  CHECK_THROWS_WITH(require_axis("lights"), Contains("lights") && Contains("light, table"));
}

TEST_CASE("Each axis changes what it is about", "[perturbation]") {
  const auto axis = GENERATE(kCamera, kFov, kLight, kTable, kFloor, kDistractors, kOccluder, kNoise,
                             kBlur, kStartPose);
  INFO(name_of(axis));
  const auto usual = make(kId, with({}));
  const auto other = make(kId, with({{axis, 1}}));
  usual->reset();
  other->reset();
  int differing = 0;
  for (int i = 0; i < 3; ++i) differing += image(*usual, i) != image(*other, i) ? 1 : 0;
  CHECK(differing == 3);
  const auto joints = [](const Batch& batch) {
    return std::vector<double>(batch.state().qpos.row(0), batch.state().qpos.row(0) + kArmJoints);
  };
  CHECK((joints(*usual) != joints(*other)) == (axis == kStartPose));
}

TEST_CASE("Images for people show the scene's changes, not those of the sensors",
          "[perturbation]") {
  const auto usual = make(kId, with({}));
  const auto sensors = make(kId, with({{kCamera, 1}, {kFov, 1}, {kNoise, 1}, {kBlur, 1}}));
  const auto scene = make(kId, with({{kLight, 1}}));
  for (Batch* batch : {usual.get(), sensors.get(), scene.get()}) batch->reset();
  CHECK(image(*sensors, 0, "render_camera") == image(*usual, 0, "render_camera"));
  CHECK(image(*scene, 0, "render_camera") != image(*usual, 0, "render_camera"));
}

TEST_CASE("Levels scale the same draws", "[perturbation]") {
  const auto values = [](double level) {
    const auto batch = make(kId, with({{kStartPose, level}}));
    batch->reset();
    const ColumnView view = test::memory_of(*batch).find("perturbations");
    const double* row = test::row<double>(view, 1);
    return std::vector<double>(row, row + view.field->width);
  };
  const std::vector<double> full = values(1);
  const std::vector<double> half = values(0.5);
  for (std::size_t i = 0; i < full.size(); ++i) CHECK(half[i] == Approx(0.5 * full[i]));
  CHECK(std::ranges::count_if(full, [](double x) { return std::abs(x) > 0.5; }) > 0);
}

TEST_CASE("Perturbations are pinned like other draws", "[perturbation]") {
  MakeOptions options = with({{kStartPose, 0.1}});
  options.pins = {{"perturb_start_pose", {1, 0, 0, 0, 0, 0, -1}},
                  {kRobotNoiseVariable, {0, 0, 0, 0, 0, 0, 0}}};
  const auto batch = make(kId, options);
  batch->reset();
  CHECK(batch->state().qpos.row(0)[0] == Approx(0.12));
  CHECK(batch->state().qpos.row(0)[1] == Approx(0));

  options.pins = {{"perturb_start_pose", {2, 0, 0, 0, 0, 0, 0}}};
  CHECK_THROWS_WITH(make(kId, options), Contains("perturb_start_pose") && Contains("-1 to 1"));
  options.pins = {{"perturb_camera", {0}}};
  CHECK_THROWS_WITH(make(kId, options), Contains("no draw named 'perturb_camera'"));
}

TEST_CASE("What is hidden does not show in perturbations", "[perturbation]") {
  const auto values = [](double target) {
    MakeOptions options = with(all_axes(1));
    options.pins = {{"target", {target}}};
    const auto batch = make(kId, options);
    batch->reset();
    const ColumnView view = test::memory_of(*batch).find("perturbations");
    const double* row = test::row<double>(view, 0);
    return std::vector<double>(row, row + view.field->width);
  };
  CHECK(values(0) == values(3));
}

TEST_CASE("Perturbed episodes do not depend on threads, batch size and slot", "[perturbation]") {
  MakeOptions options = with(all_axes(0.6), ObsMode::kRgb, 5);
  options.seed = 40;
  const auto batch = make(kId, options);
  options.threads = 3;
  options.chunk = 1;
  const auto threads = make(kId, options);
  CHECK(shown(*threads) == shown(*batch));

  options.num_envs = 1;
  options.seed = 43;
  const auto alone = make(kId, options);
  alone->reset();
  const std::vector<std::uint64_t> seeds = {40, 41, 42, 43, 44};
  batch->reset({.mask = {}, .seeds = seeds});
  for (int step = 0; step < 20; ++step) {
    CHECK(test::env_bytes(*alone, 0) == test::env_bytes(*batch, 3));
    const std::size_t size = alone->images().rgb.size();
    CHECK(std::ranges::equal(alone->images().rgb, batch->images().rgb.subspan(3 * size, size)));
    test::step(*alone, Policy::kOracle);
    test::step(*batch, Policy::kOracle);
  }
}

// A batch with late commands, and one without.
std::pair<std::unique_ptr<Batch>, std::unique_ptr<Batch>> late_and_usual(double level) {
  MakeOptions options = with({{kActionDelay, level}}, ObsMode::kState, 2);
  options.freeze_cue = false;
  auto late = make(kId, options);
  options.perturbations.clear();
  auto usual = make(kId, options);
  late->reset();
  usual->reset();
  return {std::move(late), std::move(usual)};
}

TEST_CASE("A late command has its effect some steps later", "[perturbation]") {
  const auto [late, usual] = late_and_usual(0.5);
  constexpr int kDelay = 2;
  std::vector<std::vector<float>> given;
  RandomStream random(3, 0, 0);
  for (int step = 0; step < 15; ++step) {
    std::vector<float> actions = test::zeros(*late);
    for (float& one : actions) one = static_cast<float>(random.uniform(-1, 1));
    given.push_back(actions);
    late->step(actions);
    if (step < kDelay) {
      usual->step_no_action();
    } else {
      usual->step(given[static_cast<std::size_t>(step - kDelay)]);
    }
    CHECK(std::equal(late->state().qpos.row(0), late->state().qpos.row(0) + kRobotJoints,
                     usual->state().qpos.row(0)));
  }
}

TEST_CASE("Steps without a command are as late as commands", "[perturbation]") {
  const auto [late, usual] = late_and_usual(0.25);
  std::vector<float> actions(14, 0.7F);
  late->step(actions);
  usual->step_no_action();
  late->step_no_action();
  usual->step(actions);
  late->step(actions);
  usual->step_no_action();
  CHECK(std::equal(late->state().qpos.row(0), late->state().qpos.row(0) + kRobotJoints,
                   usual->state().qpos.row(0)));
}

TEST_CASE("An environment with late and noisy commands goes on after it was restored",
          "[perturbation]") {
  const auto batch = make(kId, with({{kActionDelay, 1}, {kActionNoise, 0.5}}));
  batch->reset();
  for (int i = 0; i < 7; ++i) test::step(*batch, Policy::kRandom);
  const std::vector<std::byte> saved = Snapshotter(*batch).save(1);
  std::vector<test::Bytes> expected;
  for (int i = 0; i < 8; ++i) {
    test::step(*batch, Policy::kRandom);
    expected.push_back(test::env_bytes(*batch, 1));
  }
  Snapshotter(*batch).restore(1, saved);
  for (const test::Bytes& bytes : expected) {
    test::step(*batch, Policy::kRandom);
    CHECK(test::env_bytes(*batch, 1) == bytes);
  }
}

TEST_CASE("Snapshots are refused by batches with other axes, and taken with other levels",
          "[perturbation]") {
  const auto batch = make(kId, with({{kCamera, 1}}));
  batch->reset();
  const std::vector<std::byte> saved = Snapshotter(*batch).save();
  const auto other = make(kId, with({{kLight, 1}}));
  other->reset();
  CHECK_THROWS_WITH(Snapshotter(*other).restore(saved),
                    Contains("perturbed camera") && Contains("perturbed light"));
  const auto half = make(kId, with({{kCamera, 0.5}}));
  half->reset();
  CHECK(image(*half, 0) != image(*batch, 0));
  Snapshotter(*half).restore(saved);
  CHECK(image(*half, 0) == image(*batch, 0));
}

TEST_CASE("Noise of actions has its deviation and leaves the gripper alone", "[perturbation]") {
  MakeOptions options = with({{kActionNoise, 1}}, ObsMode::kState, 200);
  options.freeze_cue = false;
  const auto batch = make(kId, options);
  batch->reset();
  batch->step(test::zeros(*batch));
  const ColumnView action = test::memory_of(*batch).find("action");
  double square = 0;
  for (int i = 0; i < 200; ++i) {
    const float* row = test::row<float>(action, i);
    for (int k = 0; k < 6; ++k) square += static_cast<double>(row[k]) * static_cast<double>(row[k]);
    CHECK(row[6] == 0);
  }
  CHECK(std::sqrt(square / 1200) == Approx(0.2).epsilon(0.08));
}

TEST_CASE("Other wordings are those that an episode does not use", "[perturbation]") {
  const auto batch = make(kId, with({{kInstruction, 1}}, ObsMode::kState, 16));
  batch->reset();
  for (int i = 0; i < 16; ++i) {
    const std::vector<std::string> others = Queries(*batch).paraphrases(i);
    CHECK(others.size() == 10);
    CHECK(std::ranges::count(others, Queries(*batch).instruction(i)) == 0);
  }
}

TEST_CASE("Instructions are worded otherwise, with the same numbers", "[perturbation]") {
  for (const char* id : {kId, "RotateLenientPos-VLA-v0"}) {
    const auto batch = make(id, with({{kInstruction, 1}}, ObsMode::kState, 64));
    const auto usual = make(id, with({}, ObsMode::kState, 64));
    batch->reset();
    usual->reset();
    std::set<std::string> wordings;
    for (int i = 0; i < 64; ++i) {
      const std::string own = Queries(*usual).instruction(i);
      const std::string other = Queries(*batch).instruction(i);
      const std::vector<std::string> known = paraphrases(own);
      CHECK((other == own || std::ranges::find(known, other) != known.end()));
      wordings.insert(other);
    }
    CHECK(wordings.size() > 8);
  }
}

// The means of the pixels that show a thing, or nothing where it is not seen.
std::optional<Eigen::Vector2d> middle_of(const Batch& batch, const std::string& name) {
  const ObservedImages images = batch.images();
  const auto names = images.segmentation_names;
  const auto segment = std::ranges::find(names, name) - names.begin();
  Eigen::Vector2d sum(0, 0);
  int count = 0;
  for (int y = 0; y < 128; ++y) {
    for (int x = 0; x < 128; ++x) {
      if (images.segmentation[static_cast<std::size_t>(2 * (128 * y + x))] != segment) continue;
      sum += Eigen::Vector2d(x + 0.5, y + 0.5);
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

TEST_CASE("Camera matrices are those of the moved cameras", "[perturbation]") {
  MakeOptions options = with({{kCamera, 1}, {kFov, 1}}, ObsMode::kRgbSegmentation, 1);
  const auto batch = make(kId, options);
  int compared = 0;
  for (int episode = 0; episode < 5; ++episode) {
    batch->reset();
    std::vector<float> extrinsic(12);
    std::vector<float> intrinsic(9);
    Queries(*batch).camera_params("base_camera", 128, 128, {extrinsic, {}, intrinsic});
    for (int prop = 0; prop < batch->state().num_props; ++prop) {
      if (batch->state().status_of(0, prop) == PropStatus::kHidden) continue;
      const auto seen =
          middle_of(*batch, batch->physics_model().props()[static_cast<std::size_t>(prop)].name);
      if (!seen) continue;
      const Eigen::Map<const Eigen::Matrix<float, 3, 4, Eigen::RowMajor>> outer(extrinsic.data());
      const Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>> inner(intrinsic.data());
      const Eigen::Vector3d at = Eigen::Map<const Vec3>(batch->state().prop_pos_of(0, prop));
      const Eigen::Vector3d pixel =
          (inner * (outer * at.cast<float>().homogeneous())).cast<double>();
      CHECK((pixel.head<2>() / pixel[2] - *seen).norm() < 2.5);
      ++compared;
    }
  }
  CHECK(compared >= 5);
}

TEST_CASE("Values that no draw has are read as the nearest that it can have", "[perturbation]") {
  const auto batch = make(kId, with(all_axes(1), ObsMode::kRgb, 2));
  batch->reset();
  const ColumnView view = test::memory_of(*batch).find("perturbations");
  for (const double wild : {1e300, -1e300, std::nan(""), -536870912.0}) {
    double* row = reinterpret_cast<double*>(view.row(0));
    std::fill_n(row, view.field->width, wild);
    for (int i = 0; i < 6; ++i) batch->step(test::act(*batch, Policy::kRandom));
    CHECK(image(*batch, 0).size() == 3 * 64 * 64);
    CHECK_FALSE(Queries(*batch).instruction(0).empty());
  }
}

TEST_CASE("The last images of perturbed episodes are those of batches that go on",
          "[perturbation]") {
  MakeOptions options = with({{kCamera, 1}, {kNoise, 1}}, ObsMode::kRgb, 2);
  options.max_episode_steps = 4;
  options.auto_reset = AutoReset::kOff;
  const auto held = make(kId, options);
  options.auto_reset = AutoReset::kSameStep;
  const auto renewed = make(kId, options);
  held->reset();
  renewed->reset();
  for (int i = 0; i < 4; ++i) {
    test::step(*held, Policy::kOracle);
    test::step(*renewed, Policy::kOracle);
  }
  CHECK(std::ranges::equal(held->images().rgb, test::final_images(*renewed).rgb));
  const std::vector<std::uint8_t> last(held->images().rgb.begin(), held->images().rgb.end());
  held->step(test::zeros(*held));
  CHECK(std::ranges::equal(held->images().rgb, last));
}

TEST_CASE("OpenGL draws perturbed observations", "[perturbation][egl]") {
  if (!has_egl()) return;
  MakeOptions options =
      with({{kCamera, 1}, {kFov, 1}, {kLight, 1}, {kTable, 1}, {kFloor, 1}, {kDistractors, 1}},
           ObsMode::kRgb, 4);
  const auto by_rays = make(kId, options);
  options.image_options.renderer = "egl";
  const auto by_gl = make(kId, options);
  by_rays->reset();
  by_gl->reset();
  const auto one = by_rays->images().rgb;
  const auto other = by_gl->images().rgb;
  double difference = 0;
  for (std::size_t i = 0; i < one.size(); ++i) difference += std::abs(one[i] - other[i]);
  CHECK(difference / static_cast<double>(one.size()) < 3);
}

TEST_CASE("Distractors hide no prop and stand on the table", "[perturbation]") {
  for (const char* id : {"SeqOfColors7-VLA-v0", "RememberShapeAndColor5x3-VLA-v0",
                         "GatherAndRecall9-VLA-v0", "InterceptGrabFast-VLA-v0"}) {
    INFO(id);
    const auto usual = make(id, with({}, ObsMode::kRgbSegmentation, 8));
    const auto other = make(id, with({{kDistractors, 1}}, ObsMode::kRgbSegmentation, 8));
    usual->reset();
    other->reset();
    const auto names = other->images().segmentation_names;
    const auto known = static_cast<std::int16_t>(usual->images().segmentation_names.size());
    CHECK(std::ranges::equal(usual->images().segmentation_names,
                             names.first(static_cast<std::size_t>(known))));
    std::set<std::string> seen;
    for (int step = 0; step < 30; ++step) {
      const auto before = usual->images().segmentation;
      const auto after = other->images().segmentation;
      bool kept = true;
      for (std::size_t i = 0; i < before.size(); i += 2) {  // of the base camera
        const bool new_thing = after[i] >= known;
        if (new_thing) seen.insert(names[static_cast<std::size_t>(after[i])]);
        const std::string& hidden = names[static_cast<std::size_t>(before[i])];
        kept &= new_thing ? hidden == "table" || hidden == "ground" : after[i] == before[i];
      }
      CHECK(kept);
      test::step(*usual, Policy::kOracle);
      test::step(*other, Policy::kOracle);
    }
    CHECK(seen.size() == kMaxDistractors);
  }
}

}  // namespace
}  // namespace engram
