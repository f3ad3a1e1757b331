#include "core/batch/batch_group.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/ieee_scope.h"
#include "core/base/processors.h"
#include "core/batch/scripted_policy.h"

namespace engram {
namespace {

// Parts without their batches' owners, for GroupOutputs.
template <class Parts>
std::vector<GroupPart> plain(const Parts& parts) {
  return {parts.begin(), parts.end()};
}

[[noreturn]] void refuse_mixed(const Batch& one, const Batch& other, const char* what,
                               const std::string& of_one, const std::string& of_other) {
  throw Error(Error::kInvalidArgument, std::string(what) + ": " + of_one + " of " + one.info().id +
                                           " and " + of_other + " of " + other.info().id +
                                           " given, one for all tasks needed");
}

void require_alike(const Batch& one, const Batch& other) {
  const BatchOptions& a = one.options();
  const BatchOptions& b = other.options();
  if (one.control_mode() != other.control_mode()) {
    refuse_mixed(one, other, "control mode", name_of(one.control_mode()),
                 name_of(other.control_mode()));
  }
  if (a.obs_mode != b.obs_mode) {
    refuse_mixed(one, other, "observation mode", name_of(a.obs_mode), name_of(b.obs_mode));
  }
  if (a.auto_reset != b.auto_reset) {
    refuse_mixed(one, other, "auto-reset", name_of(a.auto_reset), name_of(b.auto_reset));
  }
}

// Whole blocks of lanes, and several segments for each thread.
int segment_length(int lanes, int num_envs, int threads) {
  const int share = std::min(num_envs / (threads * 8), 16);
  return std::max(lanes, share - share % lanes);
}

// Claims a worker of a batch for one range. There is always a free one.
class WorkerClaim {
 public:
  WorkerClaim(std::atomic<bool>* busy, int workers, int first) noexcept : busy_(busy) {
    worker_ = first % workers;
    while (busy_[worker_].exchange(true, std::memory_order_acquire)) {
      worker_ = (worker_ + 1) % workers;
    }
  }
  ~WorkerClaim() { busy_[worker_].store(false, std::memory_order_release); }
  WorkerClaim(const WorkerClaim&) = delete;
  WorkerClaim& operator=(const WorkerClaim&) = delete;

  int worker() const noexcept { return worker_; }

 private:
  std::atomic<bool>* busy_;
  int worker_;
};

}  // namespace

BatchGroup::BatchGroup(std::unique_ptr<Batch> batch)
    : num_envs_(batch->num_envs()), outputs_({{batch.get(), 0}}, false) {
  Part& part = parts_.emplace_back();
  part.batch = batch.get();
  part.owned = std::move(batch);
}

BatchGroup::BatchGroup(std::vector<std::unique_ptr<Batch>> batches, int threads)
    : parts_([&] {
        if (batches.empty()) {
          throw Error(Error::kInvalidArgument, "no task given, at least one needed");
        }
        std::vector<Part> parts(batches.size());
        for (std::size_t i = 0; i < batches.size(); ++i) {
          parts[i].batch = batches[i].get();
          require_alike(*parts.front().batch, *batches[i]);
          parts[i].first = num_envs_;
          parts[i].owned = std::move(batches[i]);
          num_envs_ += parts[i].batch->num_envs();
          const auto workers = static_cast<std::size_t>(parts[i].batch->options().threads);
          parts[i].busy = std::make_unique<std::atomic<bool>[]>(workers);
        }
        return parts;
      }()),
      outputs_(plain(parts_), true) {
  if (threads == 0) threads = std::min(available_processors(), kMaxThreads);
  for (int i = 0; i < num_parts(); ++i) {
    if (part(i).rules_ != nullptr) continue;  // which shares its own work
    const int envs = part(i).num_envs();
    const int length = segment_length(part(i).simulator_->lanes(), num_envs_, threads);
    for (int begin = 0; begin < envs; begin += length) {
      segments_.push_back({i, {begin, std::min(begin + length, envs)}});
    }
  }
  pool_.emplace(std::clamp(static_cast<int>(segments_.size()), 1, threads));
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    outputs_.add_copies(i, parts_[i].copies[0]);
  }
  attach();
}

BatchGroup::~BatchGroup() = default;

int BatchGroup::state_dim() const {
  if (!is_common()) return part(0).state_dim();
  return find_array(outputs(), "observation")->field.width;
}

int BatchGroup::horizon() const {
  int longest = 0;
  for (const Part& part : parts_) longest = std::max(longest, part.batch->info().horizon);
  return longest;
}

int BatchGroup::part_of(int env) const {
  if (env < 0 || env >= num_envs_) {
    throw Error(Error::kInvalidArgument, "environment " + std::to_string(env) + " given, 0 to " +
                                             std::to_string(num_envs_ - 1) + " allowed");
  }
  const auto after = std::ranges::upper_bound(parts_, env, {}, &Part::first);
  return static_cast<int>(after - parts_.begin()) - 1;
}

// Calls f(batch, worker, segment) for all segments, on all threads.
template <class F>
void BatchGroup::run(F&& f) {
  pool_->run(static_cast<int>(segments_.size()), 1, [&](int worker, int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const Segment& segment = segments_[static_cast<std::size_t>(i)];
      Part& part = parts_[static_cast<std::size_t>(segment.part)];
      const WorkerClaim claim(part.busy.get(), part.batch->options().threads, worker);
      f(part, claim.worker(), segment);
    }
  });
}

void BatchGroup::reset(const ResetRequest& request) {
  if (!is_common()) {
    part(0).reset(request);
    return;
  }
  const IeeeScope scope;
  const auto count = static_cast<std::size_t>(num_envs_);
  if (!request.mask.empty()) require_length("reset mask", request.mask.size(), count);
  if (!request.seeds.empty()) require_length("reset seeds", request.seeds.size(), count);
  std::vector<ResetRequest> requests(parts_.size(), request);
  std::vector<std::optional<Batch::CheckedReset>> resets(parts_.size());
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const auto first = static_cast<std::size_t>(parts_[i].first);
    const auto envs = static_cast<std::size_t>(parts_[i].batch->num_envs());
    ResetRequest& own = requests[i];
    if (!own.mask.empty()) own.mask = own.mask.subspan(first, envs);
    if (!own.seeds.empty()) own.seeds = own.seeds.subspan(first, envs);
    const bool concerned =
        own.mask.empty() || std::ranges::any_of(own.mask, [](auto chosen) { return chosen != 0; });
    if (concerned) resets[i].emplace(parts_[i].batch->checked_reset(own));
  }
  run([&](Part& part, int worker, const Segment& segment) {
    const auto& reset = resets[static_cast<std::size_t>(segment.part)];
    if (reset) part.batch->reset_range(worker, segment.envs, *reset);
  });
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    Batch& batch = *parts_[i].batch;
    if (resets[i] && batch.rules_ != nullptr) batch.reset_batch_task(*resets[i]);
    if (resets[i]) batch.started_ = true;
  }
}

void BatchGroup::check_actions(std::span<const float> actions) const {
  if (!is_common()) {
    part(0).check_actions(actions);
    return;
  }
  const auto dim = static_cast<std::size_t>(action_dim());
  for (const Part& part : parts_) part.batch->require_started("step");
  require_length("actions", actions.size(), static_cast<std::size_t>(num_envs_) * dim);
  Batch::require_finite(actions, dim);
  for (const Part& part : parts_) {
    if (part.batch->options().after_end == AfterEnd::kRefuse) part.batch->refuse_ended(part.first);
  }
}

void BatchGroup::step(std::span<const float> actions) {
  check_actions(actions);
  step_all(actions.data());
}

void BatchGroup::step_no_action() {
  for (const Part& part : parts_) part.batch->check_no_action(part.first);
  step_all(nullptr);
}

void BatchGroup::step_all(const float* actions) {
  take_turn();
  if (!is_common()) {
    part(0).step_all(actions);
    return;
  }
  const auto actions_of = [&](const Part& part) {
    return actions == nullptr
               ? nullptr
               : actions + static_cast<std::ptrdiff_t>(part.first) * part.batch->action_dim();
  };
  run([&](Part& part, int worker, const Segment& segment) {
    part.batch->step_range(worker, segment.envs, actions_of(part));
  });
  for (const Part& part : parts_) {
    if (part.batch->rules_ != nullptr) part.batch->step_batch_task(actions_of(part), {});
  }
}

void BatchGroup::act(Policy policy, std::span<float> actions) {
  if (!is_common()) {
    ScriptedPolicy(part(0), policy).act(actions);
    return;
  }
  const IeeeScope scope;
  const auto dim = static_cast<std::size_t>(action_dim());
  require_length("actions", actions.size(), static_cast<std::size_t>(num_envs_) * dim);
  for (const Part& part : parts_) ScriptedPolicy(*part.batch, policy).check();
  run([&](Part& part, int /*worker*/, const Segment& segment) {
    float* const own = actions.data() + static_cast<std::size_t>(part.first) * dim;
    ScriptedPolicy(*part.batch, policy).act_range(segment.envs, own);
  });
  for (const Part& part : parts_) {
    if (part.batch->rules_ == nullptr) continue;
    const auto length = static_cast<std::size_t>(part.batch->num_envs()) * dim;
    ScriptedPolicy(*part.batch, policy)
        .act(actions.subspan(static_cast<std::size_t>(part.first) * dim, length));
  }
}

// --- arrays of users ---

void BatchGroup::check_targets(std::span<const OutputTarget> targets) const {
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const OutputTarget& target = targets[i];
    const OutputArray* const array = find_array(outputs(), target.name);
    if (array == nullptr) {
      throw Error(Error::kUnknownId, "no output named '" + target.name + "' to be written");
    }
    const std::size_t needed = array->row_bytes() * static_cast<std::size_t>(num_envs_);
    if (target.data == nullptr || target.bytes != needed) {
      throw Error(Error::kInvalidArgument,
                  "array for " + target.name + ": " +
                      (target.data == nullptr ? std::string("no address")
                                              : std::to_string(target.bytes) + " bytes") +
                      " given, " + std::to_string(needed) + " bytes needed");
    }
    for (const OutputTarget& earlier : targets.first(i)) {
      if (earlier.name == target.name) {
        throw Error(Error::kInvalidArgument,
                    "two arrays for " + target.name + " given, one allowed");
      }
    }
  }
}

void BatchGroup::write_to(std::span<const OutputTarget> first,
                          std::span<const OutputTarget> second) {
  if (std::ranges::any_of(parts_, [](const Part& part) { return part.batch->started_; })) {
    throw Error(Error::kBadState,
                "arrays for outputs given after the first reset; give them before");
  }
  check_targets(first);
  check_targets(second);
  for (const OutputTarget& target : second) {
    const bool paired = std::ranges::any_of(
        first, [&target](const OutputTarget& one) { return one.name == target.name; });
    if (!paired || first.size() != second.size()) {
      throw Error(Error::kInvalidArgument,
                  "arrays that take turns: both must be for the same outputs");
    }
  }
  takes_turns_ = !second.empty();
  for (Part& part : parts_) {
    part.copies = {};
    part.images = {};
  }
  add_targets(first, 0);
  if (takes_turns_) add_targets(second, 1);
  for (Part& part : parts_) part.batch->draw_into(part.images[0]);
  output_buffer_ = 0;
  show_images();
  attach();
}

void BatchGroup::add_targets(std::span<const OutputTarget> targets, std::size_t output_buffer) {
  std::vector<OutputArray> images;
  user_images_[output_buffer].clear();
  for (const OutputTarget& target : targets) {
    const OutputArray* const array = find_array(outputs(), target.name);
    auto* const data = static_cast<std::byte*>(target.data);
    if (array->shape.size() != 4) continue;
    user_images_[output_buffer].emplace_back(array - outputs().data(), data);
    images.push_back(*array);
    images.back().data = data;
  }
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    Part& part = parts_[i];
    outputs_.add_copies(i, part.copies[output_buffer]);
    part.images[output_buffer] = outputs_.images_in(i, images);
    for (const OutputTarget& target : targets) {
      const OutputArray& array = *find_array(outputs(), target.name);
      if (array.shape.size() == 4) continue;
      outputs_.add_copies_into(i, array, static_cast<std::byte*>(target.data),
                               part.copies[output_buffer]);
    }
  }
}

void BatchGroup::attach() {
  for (Part& part : parts_)
    part.batch->attach(&part.copies[static_cast<std::size_t>(output_buffer_)]);
}

void BatchGroup::take_turn() {
  if (!takes_turns_) return;
  output_buffer_ = 1 - output_buffer_;
  for (Part& part : parts_) {
    part.batch->swap_to(part.images[static_cast<std::size_t>(output_buffer_)]);
  }
  show_images();
  attach();
}

void BatchGroup::show_images() {
  for (const auto& [output, data] : user_images_[static_cast<std::size_t>(output_buffer_)]) {
    outputs_.redirect(output, data);
  }
}

}  // namespace engram
