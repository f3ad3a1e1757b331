// Demonstrations of the oracle for imitation learning (docs/datasets.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "protocol/datasets/labels.h"
#include "protocol/datasets/npz.h"
#include "protocol/io/bytes.h"
#include "protocol/make/make.h"

namespace engram {

// Rule for the episodes of a task that become demonstrations. Attempt k plays the seeds start + k *
// batch, ..., start + (k + 1) * batch - 1.
struct CollectionRule {
  int batch = 1;      // episodes of an attempt; all are dropped unless all succeed
  int min_steps = 0;  // shorter episodes are dropped
};

// In pd_joint_delta_pos, whose joints are too slow for some episodes, each counts for itself.
CollectionRule collection_rule(const RegistryEntry& entry,
                               ControlMode mode = ControlMode::kPdEeDeltaPose);

// What is recorded beside colours, proprio and actions, on request.
struct Additions {
  bool labels = false;  // protocol/datasets/labels.h
  bool depth = false;   // of both cameras, as the next
  bool segmentation = false;
  // The row of the observation mode of that name; one of them at most.
  bool state = false;
  bool objects = false;

  friend bool operator==(const Additions&, const Additions&) = default;
};

// Options of the environments for recording and replay: the library's defaults with images,
// episodes ending at success and then left alone. Labels need depth and segmentation, too. Throws
// Error for state and objects at once.
MakeOptions demonstration_options(const Additions& additions = {});

// Appends a step's values to those of an episode.
template <class T>
void append(std::vector<T>& to, std::span<const T> values) {
  to.insert(to.end(), values.begin(), values.end());
}

// Seeds are stored as int64.
inline constexpr std::uint64_t kMaxDemonstrationSeed = INT64_MAX;

// The result of one episode.
struct Demonstration {
  bool success = false;
  std::int32_t length = 0;  // control steps
  // Set for what is kept only:
  double reward_sum = 0;
  std::vector<std::byte> file;  // the .npz file's content

  // Serialization, for other processes.
  void pack(ByteWriter& out) const;
  static Demonstration unpack(ByteReader& in);
};

// Records the episode of one environment of a batch, from its first observation to its first
// success.
class DemonstrationRecorder {
 public:
  // The batch has the demonstration_options of the additions.
  explicit DemonstrationRecorder(const Additions& additions = {}) : additions_(additions) {
    if (additions.labels) labels_.emplace();
  }

  // After the environment's reset.
  void start(const Batch& batch, int index);
  // Before a step: limits the environment's action to its space and keeps it with the observation.
  void before_step(const Batch& batch, int index, std::span<float> action);
  // After it.
  void after_step(const Batch& batch, int index);
  // The result, once the episode has ended.
  // Without keep_failures, one that fails has no file.
  Demonstration finish(NpzCompression compression = NpzCompression::kDeflated,
                       bool keep_failures = false) const;

 private:
  bool has_rows() const { return additions_.state || additions_.objects; }

  std::int64_t seed_ = 0;
  std::string instruction_;
  std::int64_t height_ = 0;
  std::int64_t width_ = 0;
  std::vector<std::uint8_t> rgb_;
  std::vector<float> proprio_;
  std::vector<float> actions_;
  std::vector<float> rewards_;
  std::vector<std::int32_t> successes_;
  std::vector<std::int32_t> dones_;
  Additions additions_;
  std::vector<std::uint16_t> depth_;
  std::vector<std::uint16_t> segmentation_;
  std::vector<std::string> segmentation_names_;
  std::vector<float> rows_;  // of state or objects
  std::optional<LabelRecorder> labels_;
};

}  // namespace engram
