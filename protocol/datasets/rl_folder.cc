#include "protocol/datasets/rl_folder.h"

#include <algorithm>
#include <string>

#include "core/batch/scripted_policy.h"
#include "protocol/datasets/npz.h"
#include "protocol/io/files.h"
#include "protocol/io/json_values.h"
#include "protocol/make/rows.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRoot = "MIKASA-Robo";

void append_as_floats(std::vector<float>& to, const double* values, int count) {
  std::transform(values, values + count, std::back_inserter(to),
                 [](double value) { return static_cast<float>(value); });
}

bool has_data(const fs::path& folder) {
  return std::ranges::any_of(fs::directory_iterator(folder), [](const fs::directory_entry& one) {
    return one.path().extension() == ".npz";
  });
}

// The plan, apart from the number of episodes, which may grow.
Json plan_document(const RegistryEntry& entry, const CollectionPlan& plan) {
  return JsonTable{{"env_id", entry.id}, {"engram", provenance(entry, plan)}};
}

}  // namespace

MakeOptions rl_recording_options(const CollectionPlan& plan) {
  MakeOptions options;
  options.obs_mode = ObsMode::kRgb;
  options.auto_reset = AutoReset::kOff;
  options.terminate_on_success = false;
  options.terminate_on_failure = false;
  plan.set_environment(options);
  return options;
}

// --- one episode ---

void RlRecorder::start() { *this = RlRecorder(); }

void RlRecorder::before_step(const Batch& batch, int index, std::span<const float> action) {
  const State& state = batch.state();
  append(rgb_, row_of(batch.images().rgb, batch, index));
  append_as_floats(joints_, state.tcp_pos.row(index), 3);
  append_as_floats(joints_, state.tcp_quat.row(index), 4);
  append_as_floats(joints_, state.qpos.row(index), kRobotJoints);
  append_as_floats(joints_, state.qvel.row(index), kRobotJoints);
  append(actions_, action);
}

void RlRecorder::after_step(const Batch& batch, int index) {
  const auto i = static_cast<std::size_t>(index);
  rewards_.push_back(batch.outputs().reward[i]);
  successes_.push_back(batch.outputs().success[i] != 0 ? 1 : 0);
  dones_.push_back((batch.outputs().terminated[i] | batch.outputs().truncated[i]) != 0 ? 1 : 0);
}

std::vector<std::byte> RlRecorder::file(const Batch& batch) const {
  const auto steps = static_cast<std::int64_t>(rewards_.size());
  if (steps != batch.info().horizon) {
    throw Error(Error::kUnavailable,
                batch.info().id + ": an episode ended after " + std::to_string(steps) + " of " +
                    std::to_string(batch.info().horizon) + " control steps: its physics diverged");
  }
  const auto per_step = [steps](const auto& values) {
    return static_cast<std::int64_t>(values.size()) / steps;
  };
  const std::int64_t height = batch.options().images.height;
  const std::int64_t width = batch.options().images.width;
  const std::vector<NpyArray> arrays = {
      {"rgb", NpyType::kUint8, {steps, height, width, 6}, bytes_of(rgb_)},
      {"joints", NpyType::kFloat32, {steps, per_step(joints_)}, bytes_of(joints_)},
      {"action", NpyType::kFloat32, {steps, per_step(actions_)}, bytes_of(actions_)},
      {"reward", NpyType::kFloat32, {steps}, bytes_of(rewards_)},
      {"success", NpyType::kInt64, {steps}, bytes_of(successes_)},
      {"done", NpyType::kInt64, {steps}, bytes_of(dones_)},
  };
  return npz_bytes(arrays, NpzCompression::kStored);
}

// --- the folder ---

RlFolder::RlFolder(const fs::path& root, const RegistryEntry& entry, const CollectionPlan& plan)
    : entry_(&entry),
      plan_(plan),
      path_(root / kRoot / "unbatched" / entry.id),
      note_(root / kRoot / (std::string(entry.id) + ".json")) {
  if (plan.additions != Additions() || plan.joint_proprio) {
    throw Error(Error::kInvalidArgument,
                "labels, depth, segmentation, state, objects or joint_proprio given; RL data have "
                "none of them: "
                "arrays of images, joints, actions, rewards, success and done alone");
  }
  plan_.keep_failures = true;
  require_mode_of(Policy::kOracle, plan.control_mode.value_or(entry.control_mode));
  require_storable_seeds(plan.start_seed, static_cast<std::uint64_t>(plan.episodes));
  horizon_ = make_task(entry.id, plan.constants)->info().horizon;
  present_.resize(static_cast<std::size_t>(plan.episodes));
  check_plan();
  find_episodes();
}

void RlFolder::open() {
  require_writable_folder(path_);
  lock_ = std::make_unique<FolderLock>(path_);
  check_plan();  // again: another run may have been here meanwhile
  find_episodes();
  write_file(note_, to_text(plan_document(*entry_, plan_)));
}

void RlFolder::find_episodes() {
  for (int i = 0; i < plan_.episodes; ++i) {
    const bool there = fs::exists(file(i));
    present_[static_cast<std::size_t>(i)] = there ? 1 : 0;
    if (!there) continue;
    const std::vector<std::int64_t> shape = NpzFile(file(i)).shape("success", NpyType::kInt64);
    if (shape == std::vector<std::int64_t>{horizon_}) continue;
    throw Error(Error::kIo, "'" + file(i).string() + "' is no episode of " +
                                std::to_string(horizon_) + " control steps; remove it");
  }
}

void RlFolder::check_plan() const {
  const std::optional<std::string> text = read_file(note_);
  if (!text) {
    if (!fs::exists(path_) || !has_data(path_)) return;
    throw Error(Error::kInvalidArgument,
                "'" + path_.string() + "' has episodes, but '" + note_.string() +
                    "', which says how engram collected them, is missing; another folder needed");
  }
  const Json before = parse_json(*text).value_or(Json());
  const Json* found = find(before, "engram");
  if (found == nullptr) {
    throw Error(Error::kIo, "'" + note_.string() + "' is not engram's; without it, the files of '" +
                                path_.string() + "' are trusted");
  }
  require_same_provenance(path_, *found, *entry_, plan_);
}

fs::path RlFolder::file(int episode) const {
  return path_ / ("train_data_" + std::to_string(episode) + ".npz");
}

int RlFolder::episodes() const {
  return static_cast<int>(std::ranges::count(present_, std::uint8_t{1}));
}

int RlFolder::next_missing(int from) const {
  int next = from;
  while (next < plan_.episodes && has(next)) ++next;
  return next;
}

void RlFolder::write(int episode, std::span<const std::byte> content) {
  lock_->folder().write_file(file(episode).filename().string(), content);
  present_[static_cast<std::size_t>(episode)] = 1;
}

double RlFolder::success_once() const {
  int solved = 0;
  for (int i = 0; i < plan_.episodes; ++i) {
    if (!has(i)) continue;
    const NpzFile npz(file(i));
    const auto shape = npz.shape("success", NpyType::kInt64);
    const std::vector<std::byte> values = npz.read("success", NpyType::kInt64, shape);
    solved += std::ranges::any_of(values, [](std::byte b) { return b != std::byte{}; }) ? 1 : 0;
  }
  return episodes() == 0 ? 0 : static_cast<double>(solved) / episodes();
}

}  // namespace engram
