#include "bench/bit_identity.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>
#include <vector>

#include "bench/mixed_actions.h"
#include "bench/row_hash.h"
#include "core/batch/snapshot.h"
#include "core/robot/lane_kernel.h"
#include "render/make_renderer.h"

namespace engram::bench {
namespace {

constexpr InstructionSet kBaseline = InstructionSet::kBaseline;
constexpr InstructionSet kAvx2 = InstructionSet::kAvx2;
constexpr InstructionSet kAvx512 = InstructionSet::kAvx512;
constexpr std::array<RunConfig, 18> kRunConfigs = {{{1, 0, 64, true, kBaseline},
                                                    {1, 1, 7, false, kAvx2},
                                                    {1, 5, 64, false, kAvx512},
                                                    {2, 0, 7, false, kBaseline},
                                                    {2, 1, 64, true, kAvx2},
                                                    {2, 5, 7, true, kAvx512},
                                                    {3, 0, 64, false},
                                                    {3, 1, 7, true, kBaseline},
                                                    {3, 5, 64, true, kAvx2},
                                                    {4, 0, 7, true, kAvx512},
                                                    {4, 1, 64, false},
                                                    {4, 5, 7, false, kBaseline},
                                                    {8, 0, 64, true, kAvx2},
                                                    {8, 1, 64, false, kAvx512},
                                                    {8, 5, 7, true},
                                                    {2, 0, 1, false, kBaseline},
                                                    {4, 1, 1, true, kAvx2},
                                                    {8, 5, 1, false, kAvx512}}};

constexpr int kSeeds = kSegments / 2;
// Whole episodes, and the snapshots taken of each.
constexpr int kEpisodes = 16;
constexpr int kSnapshots = (kSegments - kSeeds) / kEpisodes;
static_assert(kSeeds + kEpisodes * kSnapshots == kSegments);
constexpr RunConfig kReferenceEpisodes = {.num_envs = kEpisodes};
constexpr RunConfig kOtherEpisodes = {
    .threads = 3, .chunk = 1, .num_envs = kEpisodes, .shuffled = true};

// Start of a segment: a reset with that seed, or a snapshot.
struct SegmentStart {
  std::uint64_t seed = 0;
  std::vector<std::byte> snapshot = {};
};

// Hashes of the outputs and of the memory of one segment.
struct SegmentTrace {
  std::uint64_t outputs = 0;
  std::uint64_t memory = 0;
  int steps = 0;
  int episodes = 0;  // that ended

  bool operator==(const SegmentTrace&) const = default;
};

// Lanes of the vector kernel of that instruction set; 0, the default, where the machine has none.
int lanes_of(InstructionSet set) {
  for (int lanes = kMaxLanes; lanes > 1; lanes /= 2) {
    const LaneKernel* kernel = lane_kernel(lanes);
    if (kernel != nullptr && kernel->instruction_set == set) return lanes;
  }
  return 0;
}

class Checker {
 public:
  Checker(std::string id, const IdentityOptions& options) : id_(std::move(id)), options_(options) {}

  IdentityResult run() {
    for (int i = 0; i < kSeeds; ++i) {
      starts_.push_back({options_.seed + static_cast<std::uint64_t>(i)});
    }
    run_whole_episodes();
    run_all_segments();
    return result_;
  }

 private:
  // Segments, in the order in which they were run, and their traces.
  struct RunRecord {
    std::vector<int> segments;
    std::vector<SegmentTrace> traces;
  };

  // Whole episodes, from which the later half of the segments starts. Images are compared there
  // only.
  void run_whole_episodes() {
    std::vector<SegmentStart> snapshots(kEpisodes * kSnapshots);
    const RunRecord reference = run_episodes(kReferenceEpisodes, &snapshots);
    if (options_.obs_mode == ObsMode::kState) {
      compare(run_episodes(kOtherEpisodes, nullptr), reference);
    }
    std::move(snapshots.begin(), snapshots.end(), std::back_inserter(starts_));
  }

  void run_all_segments() {
    const RunRecord reference = run_segments(kReferenceConfig);
    advance_progress();
    for (const RunConfig& config : kRunConfigs) {
      compare(run_segments(config), reference);
      ++result_.runs;
      advance_progress();
    }
    std::vector<std::uint64_t> outputs;
    for (const SegmentTrace& trace : reference.traces) outputs.push_back(trace.outputs);
    result_.fingerprint = hash_of(outputs);
  }

  // Counts differences. A reference has every segment once, in order.
  void compare(const RunRecord& record, const RunRecord& reference) {
    for (std::size_t i = 0; i < record.traces.size(); ++i) {
      const SegmentTrace& trace = record.traces[i];
      if (trace != reference.traces[static_cast<std::size_t>(record.segments[i])]) {
        ++result_.different;
      }
      result_.env_steps += trace.steps;
      result_.episodes += trace.episodes;
    }
  }

  RunRecord run_episodes(const RunConfig& config, std::vector<SegmentStart>* snapshots) {
    const auto batch = make_batch(config, ObsMode::kState);
    MixedActions actions(*batch);
    const int horizon = batch->info().horizon;
    RunRecord record;
    record.segments = order_of(kEpisodes, config.shuffled);
    record.traces.resize(kEpisodes);
    begin(*batch, record.segments);
    for (int part = 1, step = 0; part <= kSnapshots; ++part) {
      // The last snapshots are near the end, so that segments pass it.
      const int last = std::max(0, horizon - options_.steps / 2);
      const int at = std::min(last, horizon * part / kSnapshots);
      for (; step < at; ++step) advance(*batch, actions, record.traces);
      for (int i = 0; i < kEpisodes && snapshots != nullptr; ++i) {
        (*snapshots)[static_cast<std::size_t>((part - 1) * kEpisodes + i)] = {
            batch->state().seed[i], Snapshotter(*batch).save(i)};
      }
    }
    return record;
  }

  RunRecord run_segments(const RunConfig& config) {
    const auto batch = make_batch(config, options_.obs_mode);
    MixedActions actions(*batch);
    const std::vector<int> order = order_of(kSegments, config.shuffled);
    const auto size = static_cast<std::size_t>(config.num_envs);
    RunRecord record;
    for (std::size_t next = 0; next < order.size(); next += size) {
      // The last batch is filled up with segments that have been run before.
      const std::size_t first = std::min(next, order.size() - size);
      const std::span<const int> segments = std::span(order).subspan(first, size);
      std::vector<SegmentTrace> traces(size);
      begin(*batch, segments);
      update_traces(*batch, traces);
      for (int step = 0; step < options_.steps; ++step) advance(*batch, actions, traces);
      record.segments.insert(record.segments.end(), segments.begin(), segments.end());
      record.traces.insert(record.traces.end(), traces.begin(), traces.end());
    }
    return record;
  }

  std::unique_ptr<Batch> make_batch(const RunConfig& config, ObsMode obs_mode) const {
    MakeOptions options;
    options.num_envs = config.num_envs;
    options.threads = config.threads;
    options.chunk = config.chunk;
    options.obs_mode = obs_mode;
    options.lanes = lanes_of(config.instruction_set);
    const bool has_it = is_supported(config.instruction_set);
    return options_.make_batch(has_it ? config.instruction_set : InstructionSet::kAuto, id_,
                               options);
  }

  static std::vector<int> order_of(int count, bool shuffled) {
    std::vector<int> order;
    order.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) order.push_back(shuffled ? (i * 37 + 5) % count : i);
    return order;
  }

  // Puts one segment into each slot.
  void begin(Batch& batch, std::span<const int> segments) const {
    std::vector<std::uint64_t> seeds;
    for (const int segment : segments) seeds.push_back(start_of(segment).seed);
    batch.reset({.mask = {}, .seeds = seeds});
    for (int i = 0; i < batch.num_envs(); ++i) {
      const auto& snapshot = start_of(segments[static_cast<std::size_t>(i)]).snapshot;
      if (!snapshot.empty()) Snapshotter(batch).restore(i, snapshot);
    }
  }

  const SegmentStart& start_of(int segment) const {
    return starts_[static_cast<std::size_t>(segment)];
  }

  // Random actions for even seeds, the oracle's for odd ones.
  void advance(Batch& batch, MixedActions& actions, std::vector<SegmentTrace>& traces) {
    batch.step(actions.choose(batch, [&batch](int i) { return batch.state().seed[i] % 2 == 1; }));
    update_traces(batch, traces);
    for (std::size_t i = 0; i < traces.size(); ++i) {
      ++traces[i].steps;
      traces[i].episodes += batch.state().finished[static_cast<int>(i)];
    }
  }

  void update_traces(const Batch& batch, std::vector<SegmentTrace>& traces) {
    const BatchData& data = BatchAccess::data(batch);
    row_.resize(std::max(data.outputs.row_bytes(), data.memory.row_bytes()));
    const auto chain = [&](std::uint64_t hash, const ColumnStore& store, std::size_t slot) {
      store.save_row(static_cast<int>(slot), row_);
      return chain_row(hash, std::span<const std::byte>(row_).first(store.row_bytes()), 1, 0);
    };
    for (std::size_t i = 0; i < traces.size(); ++i) {
      SegmentTrace& trace = traces[i];
      trace.outputs = chain(trace.outputs, data.outputs, i);
      trace.outputs = chain_row(trace.outputs, batch.images().rgb, traces.size(), i);
      trace.outputs = chain_row(trace.outputs, batch.images().depth, traces.size(), i);
      trace.outputs = chain_row(trace.outputs, batch.images().segmentation, traces.size(), i);
      if (observes_objects(options_.obs_mode)) {
        trace.outputs = chain_row(trace.outputs, batch.outputs().observation, traces.size(), i);
      }
      trace.memory = chain(trace.memory, data.memory, i);
    }
  }

  void advance_progress() {
    ++runs_done_;
    options_.progress(runs_done_ / static_cast<double>(kRunConfigs.size() + 1));
  }

  std::string id_;
  const IdentityOptions& options_;
  std::vector<SegmentStart> starts_;
  IdentityResult result_;
  std::vector<std::byte> row_;
  int runs_done_ = 0;
};

}  // namespace

std::unique_ptr<Batch> make_on(InstructionSet set, const std::string& id,
                               const MakeOptions& options) {
  return make(id, options,
              [set](const RenderScene& scene, const ImageSourceOptions& image_options,
                    int workers) { return make_renderer_on(set, scene, image_options, workers); });
}

std::span<const RunConfig> run_configs() { return kRunConfigs; }

IdentityResult check_identity(const std::string& id, const IdentityOptions& options) {
  return Checker(id, options).run();
}

}  // namespace engram::bench
