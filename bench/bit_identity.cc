#include "bench/bit_identity.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>
#include <vector>

#include "bench/mixed_actions.h"
#include "bench/row_hash.h"
#include "core/env/snapshot.h"
#include "core/robot/lane_kernel.h"
#include "render/document_source.h"

namespace engram::bench {
namespace {

constexpr InstructionSet kBaseline = InstructionSet::kBaseline;
constexpr InstructionSet kAvx2 = InstructionSet::kAvx2;
constexpr InstructionSet kAvx512 = InstructionSet::kAvx512;
constexpr std::array<Play, 18> kPlays = {{{1, 0, 64, true, kBaseline},
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

constexpr int kSeeds = kStretches / 2;
// Whole episodes that are played, and at how many of their steps snapshots are taken.
constexpr int kEpisodes = 16;
constexpr int kSnapshots = (kStretches - kSeeds) / kEpisodes;
static_assert(kSeeds + kEpisodes * kSnapshots == kStretches);
constexpr Play kReferenceEpisodes = {.num_envs = kEpisodes};
constexpr Play kOtherEpisodes = {.threads = 3, .chunk = 1, .num_envs = kEpisodes, .shuffled = true};

// Where a stretch begins: at a reset with that seed, or at a snapshot.
struct Beginning {
  std::uint64_t seed = 0;
  std::vector<std::byte> snapshot = {};
};

// One stretch: hashes of what the environment showed and of what it remembered.
struct Trace {
  std::uint64_t shown = 0;
  std::uint64_t remembered = 0;
  int steps = 0;
  int episodes = 0;  // that ended

  bool operator==(const Trace&) const = default;
};

// What robots move in on that instruction set; as many as there is room for where the machine has
// it not.
int lanes_of(InstructionSet set) {
  int lanes = 0;
  if (set == kBaseline) lanes = 2;
  if (set == kAvx2) lanes = 4;
  if (set == kAvx512) lanes = 8;
  return lane_kernel(lanes) != nullptr ? lanes : 0;
}

class Checker {
 public:
  Checker(std::string id, const IdentityOptions& options) : id_(std::move(id)), options_(options) {}

  IdentityResult run() {
    for (int i = 0; i < kSeeds; ++i) {
      beginnings_.push_back({options_.seed + static_cast<std::uint64_t>(i)});
    }
    play_episodes();
    play_stretches();
    return result_;
  }

 private:
  // Stretches, in the order in which they were played, and their traces.
  struct Record {
    std::vector<int> stretches;
    std::vector<Trace> traces;
  };

  // Whole episodes: where the later half of the stretches begins. Images are left to those.
  void play_episodes() {
    std::vector<Beginning> snapshots(kEpisodes * kSnapshots);
    const Record reference = run_episodes(kReferenceEpisodes, &snapshots);
    if (options_.obs_mode == ObsMode::kState) {
      compare(run_episodes(kOtherEpisodes, nullptr), reference);
    }
    std::move(snapshots.begin(), snapshots.end(), std::back_inserter(beginnings_));
  }

  void play_stretches() {
    const Record reference = run_stretches(kReferencePlay);
    advance_progress();
    for (const Play& play : kPlays) {
      compare(run_stretches(play), reference);
      ++result_.plays;
      advance_progress();
    }
    std::vector<std::uint64_t> shown;
    for (const Trace& trace : reference.traces) shown.push_back(trace.shown);
    result_.fingerprint = hash_of(shown);
  }

  // Counts what differs. A reference has every stretch once, in order.
  void compare(const Record& record, const Record& reference) {
    for (std::size_t i = 0; i < record.traces.size(); ++i) {
      const Trace& trace = record.traces[i];
      if (trace != reference.traces[static_cast<std::size_t>(record.stretches[i])]) {
        ++result_.different;
      }
      result_.env_steps += trace.steps;
      result_.episodes += trace.episodes;
    }
  }

  Record run_episodes(const Play& play, std::vector<Beginning>* snapshots) {
    const auto env = batch(play, ObsMode::kState);
    MixedActions actions(*env);
    const int horizon = env->info().horizon;
    Record record;
    record.stretches = order_of(kEpisodes, play.shuffled);
    record.traces.resize(kEpisodes);
    begin(*env, record.stretches);
    for (int part = 1, step = 0; part <= kSnapshots; ++part) {
      // The last snapshots are near the end, so that stretches pass it.
      const int last = std::max(0, horizon - options_.steps / 2);
      const int at = std::min(last, horizon * part / kSnapshots);
      for (; step < at; ++step) advance(*env, actions, record.traces);
      for (int i = 0; i < kEpisodes && snapshots != nullptr; ++i) {
        (*snapshots)[static_cast<std::size_t>((part - 1) * kEpisodes + i)] = {
            env->state().seed[i], Snapshotter(*env).save(i)};
      }
    }
    return record;
  }

  Record run_stretches(const Play& play) {
    const auto env = batch(play, options_.obs_mode);
    MixedActions actions(*env);
    const std::vector<int> order = order_of(kStretches, play.shuffled);
    const auto size = static_cast<std::size_t>(play.num_envs);
    Record record;
    for (std::size_t next = 0; next < order.size(); next += size) {
      // The last batch is filled up with stretches that have been played before.
      const std::size_t first = std::min(next, order.size() - size);
      const std::span<const int> stretches = std::span(order).subspan(first, size);
      std::vector<Trace> traces(size);
      begin(*env, stretches);
      note(*env, traces);
      for (int step = 0; step < options_.steps; ++step) advance(*env, actions, traces);
      record.stretches.insert(record.stretches.end(), stretches.begin(), stretches.end());
      record.traces.insert(record.traces.end(), traces.begin(), traces.end());
    }
    return record;
  }

  std::unique_ptr<Batch> batch(const Play& play, ObsMode obs_mode) const {
    MakeOptions options;
    options.num_envs = play.num_envs;
    options.threads = play.threads;
    options.chunk = play.chunk;
    options.obs_mode = obs_mode;
    options.lanes = lanes_of(play.instruction_set);
    const bool has_it = is_supported(play.instruction_set);
    return options_.make_batch(has_it ? play.instruction_set : InstructionSet::kAuto, id_, options);
  }

  static std::vector<int> order_of(int count, bool shuffled) {
    std::vector<int> order;
    order.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) order.push_back(shuffled ? (i * 37 + 5) % count : i);
    return order;
  }

  // Puts one stretch into each slot.
  void begin(Batch& env, std::span<const int> stretches) const {
    std::vector<std::uint64_t> seeds;
    for (const int stretch : stretches) seeds.push_back(beginning(stretch).seed);
    env.reset({.mask = {}, .seeds = seeds});
    for (int i = 0; i < env.num_envs(); ++i) {
      const auto& snapshot = beginning(stretches[static_cast<std::size_t>(i)]).snapshot;
      if (!snapshot.empty()) Snapshotter(env).restore(i, snapshot);
    }
  }

  const Beginning& beginning(int stretch) const {
    return beginnings_[static_cast<std::size_t>(stretch)];
  }

  // Random actions for even seeds, the oracle's for odd ones.
  void advance(Batch& env, MixedActions& actions, std::vector<Trace>& traces) {
    env.step(actions.choose(env, [&env](int i) { return env.state().seed[i] % 2 == 1; }));
    note(env, traces);
    for (std::size_t i = 0; i < traces.size(); ++i) {
      ++traces[i].steps;
      traces[i].episodes += env.state().finished[static_cast<int>(i)];
    }
  }

  void note(const Batch& env, std::vector<Trace>& traces) {
    row_.resize(std::max(env.outputs().row_bytes(), env.memory().row_bytes()));
    const auto chain = [&](std::uint64_t hash, const ColumnStore& store, std::size_t slot) {
      store.save_row(static_cast<int>(slot), row_);
      return chain_row(hash, std::span<const std::byte>(row_).first(store.row_bytes()), 1, 0);
    };
    for (std::size_t i = 0; i < traces.size(); ++i) {
      Trace& trace = traces[i];
      trace.shown = chain(trace.shown, env.outputs(), i);
      trace.shown = chain_row(trace.shown, env.images().rgb, traces.size(), i);
      trace.shown = chain_row(trace.shown, env.images().depth, traces.size(), i);
      trace.shown = chain_row(trace.shown, env.images().segmentation, traces.size(), i);
      if (observes_objects(options_.obs_mode)) {
        trace.shown = chain_row(trace.shown, env.observation(), traces.size(), i);
      }
      trace.remembered = chain(trace.remembered, env.memory(), i);
    }
  }

  void advance_progress() {
    ++played_;
    options_.progress(played_ / static_cast<double>(kPlays.size() + 1));
  }

  std::string id_;
  const IdentityOptions& options_;
  std::vector<Beginning> beginnings_;
  IdentityResult result_;
  std::vector<std::byte> row_;
  int played_ = 0;
};

}  // namespace

std::unique_ptr<Batch> make_on(InstructionSet set, const std::string& id,
                               const MakeOptions& options) {
  return make(id, options,
              [set](const std::string& document, const std::vector<std::string>& bodies,
                    const ImageSourceOptions& image_options, int workers) {
                return make_document_source_on(set, document, bodies, image_options, workers);
              });
}

std::span<const Play> plays() { return kPlays; }

IdentityResult check_identity(const std::string& id, const IdentityOptions& options) {
  return Checker(id, options).run();
}

}  // namespace engram::bench
