#include "protocol/datasets/recorder.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "core/batch/queries.h"
#include "protocol/make/rows.h"

namespace engram {
namespace {

// Families whose demonstrations come from a motion planner in the benchmark, one episode at a time;
// so do those of all -Long tasks. Those of the other tasks come from a trained policy, in batches.
constexpr std::array<std::string_view, 10> kPlannedFamilies = {
    "BatteriesCheckerEasy", "BatteriesCheckerHard", "BlinkCountButtonPress",
    "BunchOfColors",        "SeqOfColors",          "ChainOfColors",
    "TraceShape",           "TraceShapeSeq",        "TimedTransfer",
    "GatherAndRecall"};

}  // namespace

CollectionRule collection_rule(const RegistryEntry& entry, ControlMode mode) {
  // Tasks of users have no published plan.
  const auto of_benchmark = [](std::string_view id) {
    return std::ranges::find(registry(), id, &RegistryEntry::id) != registry().end();
  };
  if (!of_benchmark(entry.base)) return {.batch = 1, .min_steps = 0};
  const bool planned = std::find(kPlannedFamilies.begin(), kPlannedFamilies.end(), entry.family) !=
                           kPlannedFamilies.end() ||
                       entry.base.find("-Long-") != std::string_view::npos;
  if (planned) return {.batch = 1, .min_steps = 0};
  const bool alone = entry.family == "ShellGamePick" || mode == ControlMode::kPdJointDeltaPos;
  return {.batch = alone ? 1 : 10, .min_steps = 10};
}

MakeOptions demonstration_options(const Additions& additions) {
  if (additions.state && additions.objects) {
    throw Error(Error::kInvalidArgument, "state and objects given; one of them allowed");
  }
  std::string mode = "rgb";
  if (additions.depth || additions.labels) mode += "+depth";
  if (additions.segmentation || additions.labels) mode += "+segmentation";
  if (additions.state) mode += "+state";
  if (additions.objects) mode += "+objects";
  MakeOptions options;
  options.obs_mode = require_named<ObsMode>("observation mode", mode);
  options.auto_reset = AutoReset::kOff;
  options.terminate_on_success = true;  // where demonstrations end
  return options;
}

// --- one episode ---

void DemonstrationRecorder::start(const Batch& batch, int index) {
  seed_ = static_cast<std::int64_t>(batch.state().seed[index]);
  instruction_ = Queries(batch).instruction(index);
  height_ = batch.options().images.height;
  width_ = batch.options().images.width;
  rgb_.clear();
  proprio_.clear();
  actions_.clear();
  rewards_.clear();
  successes_.clear();
  dones_.clear();
  depth_.clear();
  segmentation_.clear();
  rows_.clear();
  const auto names = batch.images().segmentation_names;
  segmentation_names_.assign(names.begin(), names.end());
  if (labels_) labels_->start(batch, index);
}

void DemonstrationRecorder::before_step(const Batch& batch, int index, std::span<float> action) {
  const ActionSpace& space = batch.action_space();
  for (std::size_t i = 0; i < action.size(); ++i) {
    action[i] = std::clamp(action[i], space.low[i], space.high[i]);
  }
  append(rgb_, row_of(batch.images().rgb, batch, index));
  append(proprio_, row_of(batch.outputs().proprio, batch, index));
  append(actions_, std::span<const float>(action));
  // None of their values is negative.
  const auto add = [&](std::vector<std::uint16_t>& to, std::span<const std::int16_t> values) {
    const auto row = row_of(values, batch, index);
    to.insert(to.end(), row.begin(), row.end());
  };
  if (additions_.depth) add(depth_, batch.images().depth);
  if (additions_.segmentation) add(segmentation_, batch.images().segmentation);
  if (has_rows()) append(rows_, row_of(batch.outputs().observation, batch, index));
  if (labels_) labels_->before_step(batch, index);
}

void DemonstrationRecorder::after_step(const Batch& batch, int index) {
  const auto i = static_cast<std::size_t>(index);
  const bool success = batch.outputs().success[i] != 0;
  const bool ended = (batch.outputs().terminated[i] | batch.outputs().truncated[i]) != 0;
  rewards_.push_back(batch.outputs().reward[i]);
  successes_.push_back(success ? 1 : 0);
  dones_.push_back(success || ended ? 1 : 0);
  if (labels_) labels_->after_step(batch, index);
}

Demonstration DemonstrationRecorder::finish(NpzCompression compression, bool keep_failures) const {
  Demonstration demonstration;
  const auto steps = static_cast<std::int64_t>(successes_.size());
  const auto length = static_cast<std::int32_t>(steps);
  demonstration.length = length;
  demonstration.success = !successes_.empty() && successes_.back() != 0;
  if (!demonstration.success && !keep_failures) return demonstration;
  const std::u32string instruction = code_points(instruction_);
  const auto text = std::as_bytes(std::span<const char32_t>(instruction));
  const auto per_step = [steps](const std::vector<float>& values) {
    return static_cast<std::int64_t>(values.size()) / steps;
  };
  std::vector<NpyArray> arrays = {
      {"rgb", NpyType::kUint8, {steps, height_, width_, 6}, bytes_of(rgb_)},
      {"proprio", NpyType::kFloat32, {steps, per_step(proprio_)}, bytes_of(proprio_)},
      {"action", NpyType::kFloat32, {steps, per_step(actions_)}, bytes_of(actions_)},
      {"reward", NpyType::kFloat32, {steps}, bytes_of(rewards_)},
      {"success", NpyType::kInt32, {steps}, bytes_of(successes_)},
      {"done", NpyType::kInt32, {steps}, bytes_of(dones_)},
      {"language_instruction", NpyType::kText, {}, text, static_cast<int>(instruction.size())},
      {"success_once", NpyType::kBool, {}, bytes_of(demonstration.success)},
      {"episode_length", NpyType::kInt32, {}, bytes_of(length)},
      {"episode_seed", NpyType::kInt64, {}, bytes_of(seed_)},
  };
  const std::vector<std::int64_t> map_shape = {steps, height_, width_, 2};
  if (additions_.depth) {
    arrays.push_back({"depth", NpyType::kUint16, map_shape, bytes_of(depth_)});
  }
  std::u32string names;
  if (additions_.segmentation) {
    arrays.push_back({"segmentation", NpyType::kUint16, map_shape, bytes_of(segmentation_)});
    arrays.push_back(text_array("segmentation_names", segmentation_names_, names));
  }
  if (has_rows()) {
    const char* const name = additions_.state ? "state" : "objects";
    arrays.push_back({name, NpyType::kFloat32, {steps, per_step(rows_)}, bytes_of(rows_)});
  }
  std::optional<LabelArrays> labels;
  if (labels_) {
    labels.emplace(labels_->labels());
    append(arrays, std::span<const NpyArray>(labels->arrays()));
  }
  demonstration.reward_sum = std::accumulate(rewards_.begin(), rewards_.end(), 0.0);
  demonstration.file = npz_bytes(arrays, compression);
  return demonstration;
}

// --- between processes ---

void Demonstration::pack(ByteWriter& out) const {
  out.put(success);
  out.put(length);
  out.put(reward_sum);
  out.put(static_cast<std::uint64_t>(file.size()));
  out.append(std::span<const std::byte>(file));
}

Demonstration Demonstration::unpack(ByteReader& in) {
  Demonstration demonstration;
  demonstration.success = in.get<bool>();
  demonstration.length = in.get<std::int32_t>();
  demonstration.reward_sum = in.get<double>();
  demonstration.file = in.values<std::byte>(in.get<std::uint64_t>());
  return demonstration;
}

}  // namespace engram
