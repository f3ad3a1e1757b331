#include "protocol/eval/probe/probe_run.h"

#include <algorithm>

#include "core/base/join.h"
#include "core/batch/scripted_policy.h"
#include "protocol/eval/probe/capacity.h"
#include "protocol/eval/probe/condition_player.h"
#include "protocol/eval/probe/forgetting.h"
#include "protocol/eval/probe/interference.h"
#include "protocol/eval/probe/twins.h"
#include "protocol/io/files.h"
#include "protocol/parallel/episode_queue.h"

namespace engram {
namespace {

void refuse(const std::string& what) { throw Error(Error::kInvalidArgument, what); }

// Values of an observation's row, which policies of other tasks and constants have to fit.
int row_width(std::string_view id, const Protocol& protocol, const ConstantTable& constants) {
  return Lookahead(id, probe_environment(protocol, constants)).batch().state_dim();
}

bool observes_row(const Protocol& protocol) {
  return protocol.external && protocol.environment.obs_mode != ObsMode::kRgb;
}

ProbePlan plan_of(Probe probe, const ProbeTask& task, const Protocol& protocol,
                  const RegistryEntry* other) {
  const auto fits = [&](const ConstantTable& constants) {
    return !observes_row(protocol) || row_width(task.entry->id, protocol, constants) ==
                                          row_width(task.entry->id, protocol, task.constants);
  };
  switch (probe) {
    case Probe::kTwins:
      return plan_twins(task);
    case Probe::kForgetting:
      return plan_forgetting(task);
    case Probe::kInterference:
      return plan_interference(task, other);
    case Probe::kCapacity:
      return plan_capacity(task, fits);
  }
  return {};
}

// Name of a condition in journals.
std::string record_name(const ProbeCondition& condition) {
  return std::string(condition.entry->id) + " " + condition.name;
}

std::vector<TaskLoad> loads_of(const std::vector<ProbeCondition>& conditions, int episodes) {
  std::vector<TaskLoad> loads;
  for (const ProbeCondition& condition : conditions) {
    loads.push_back({episodes, condition.entry->horizon});
  }
  return loads;
}

// Hands out the blocks of all conditions, one after the other.
class ProbeSource final : public WorkSource {
 public:
  ProbeSource(const std::vector<ProbeCondition>& conditions, const Protocol& protocol,
              const ProbeProgress& progress, const EpisodeStore& store)
      : conditions_(conditions),
        protocol_(protocol),
        progress_(progress),
        journal_(store.journal),
        queue_(std::min(protocol.num_envs, protocol.episodes), protocol.episodes),
        results_(conditions.size(), ConditionResults(static_cast<std::size_t>(protocol.episodes))) {
    const std::vector<EpisodeRange> share =
        share_of(loads_of(conditions, protocol.episodes), store.shard);
    for (std::size_t i = 0; i < conditions.size(); ++i) {
      queue_.add(static_cast<int>(i), share[i]);
      all_ += share[i].size();
      if (journal_ != nullptr) take_known(i);
    }
  }

  std::optional<WorkItem> next() override {
    const std::optional<EpisodeQueue::Block> block = queue_.next();
    if (!block) return std::nullopt;
    return WorkItem{block->task, protocol_.start_seed + static_cast<std::uint64_t>(block->first),
                    block->count};
  }

  void accept(const WorkItem& item, Bytes bytes) override {
    ByteReader in(bytes);
    const int episode =
        static_cast<int>(item.first_seed - protocol_.start_seed) + in.get<std::int32_t>();
    const Bytes record(in.rest().begin(), in.rest().end());
    const auto condition = static_cast<std::size_t>(item.task);
    if (journal_ != nullptr) journal_->add(record_name(conditions_[condition]), episode, record);
    take(condition, episode, record);
  }

  void tick(const WorkStatus& status) override {
    if (progress_) progress_(done_, all_, status.env_steps);
  }

  const std::vector<ConditionResults>& results() const { return results_; }

 private:
  // The episode numbers of a condition that the journal has.
  void take_known(std::size_t condition) {
    const auto known = journal_->records().find(record_name(conditions_[condition]));
    if (known == journal_->records().end()) return;
    for (const auto& [episode, record] : known->second) {
      if (episode < 0 || episode >= protocol_.episodes) continue;
      queue_.remove(static_cast<int>(condition), episode);
      take(condition, episode, record);
    }
  }

  void take(std::size_t condition, int episode, const Bytes& record) {
    results_[condition][static_cast<std::size_t>(episode)] = ConditionPlayer::unpack(record);
    ++done_;
  }

  const std::vector<ProbeCondition>& conditions_;
  const Protocol& protocol_;
  const ProbeProgress& progress_;
  Journal* journal_;
  EpisodeQueue queue_;
  int done_ = 0;
  int all_ = 0;
  std::vector<ConditionResults> results_;
};

const RegistryEntry* other_task(const EvaluationSettings& settings, const Protocol& protocol,
                                const ProbeOptions& options) {
  if (options.other.empty()) return nullptr;
  const RegistryEntry& other = require_entry(options.other);
  (void)make_task(other.id, settings.constants);
  if (!observes_row(protocol)) return &other;
  const int width = row_width(other.id, protocol, settings.constants);
  for (const std::string& id : settings.tasks) {
    const int own = row_width(id, protocol, settings.constants);
    if (own == width) continue;
    refuse("the other task " + options.other + ": observations of " + std::to_string(width) +
           " values, " + std::to_string(own) + " as of " + id + " needed, or obs rgb");
  }
  return &other;
}

void check(const EvaluationSettings& settings, const ProbeOptions& options) {
  if (options.probes.empty()) {
    refuse("probes: none given, some of " + join(kProbeNames) + " allowed");
  }
  if (settings.repeat != 1)
    refuse("repeat: " + std::to_string(settings.repeat) + " given, 1 allowed");
  if (settings.commitment) refuse("a sealed run given: probes have none");
  if (settings.choices) {
    refuse("policy-choices: given, probes need a policy that answers with actions");
  }
  if (settings.tell_episodes) {
    refuse("tell-episodes: given, probes tell no policy its episodes: many of them have one seed");
  }
}

// The oracle plays where a policy is compared with it, and where a cue shows to a robot at work.
void check_control_mode(const std::vector<ProbeCondition>& conditions, const Protocol& protocol) {
  const auto needs_oracle = [&protocol](const ProbeCondition& condition) {
    return condition.control.has_value() ||
           Lookahead(condition.entry->id, probe_environment(protocol, condition.constants))
               .awaits_cue({protocol.start_seed});
  };
  try {
    require_mode_of(Policy::kOracle,
                    protocol.environment.control_mode.value_or(TaskInfo().control_mode));
  } catch (const Error& error) {
    const auto found = std::ranges::find_if(conditions, needs_oracle);
    if (found == conditions.end()) return;
    refuse(std::string(found->entry->id) + ": this probe needs the oracle, too: " + error.what());
  }
}

}  // namespace

std::vector<Probe> parse_probes(std::string_view option, const std::string& text) {
  std::vector<Probe> probes;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    const std::optional<Probe> probe = find_named<Probe>(word);
    if (!probe || std::ranges::count(probes, *probe) > 0) {
      refuse(std::string(option) + ": '" + word + "' given, " + join(kProbeNames) +
             ", each once, allowed");
    }
    probes.push_back(*probe);
    begin = end + 1;
  }
  std::ranges::sort(probes);
  return probes;
}

ProbeRun::ProbeRun(EvaluationSettings settings, Protocol protocol, ProbeOptions options)
    : settings_(std::move(settings)), protocol_(std::move(protocol)), options_(std::move(options)) {
  check(settings_, options_);
  const RegistryEntry* other = other_task(settings_, protocol_, options_);
  for (const std::string& id : settings_.tasks) {
    const ProbeTask task = probe_task(require_entry(id), settings_.constants);
    TaskSections& sections = tasks_.emplace_back(TaskSections{task.entry, {}});
    for (const Probe probe : options_.probes) {
      ProbePlan plan = plan_of(probe, task, protocol_, other);
      const std::size_t first = conditions_.size();
      for (std::size_t i = 0; i < plan.conditions.size(); ++i) {
        plan.conditions[i].name = std::string(name_of(probe)) + " " + std::to_string(i);
        conditions_.push_back(plan.conditions[i]);
      }
      sections.sections.push_back({probe, std::move(plan), first});
    }
  }
  check_control_mode(conditions_, protocol_);
}

RunHeader ProbeRun::header(const EpisodePart& part) const {
  RunHeader header{
      .kind = kProbeKind, .shard = part.shard, .command = part.command, .run = {}, .tasks = {}};
  JsonList probes;
  for (const Probe probe : options_.probes) probes.emplace_back(name_of(probe));
  header.run = JsonTable{{"settings", settings_.document()},
                         {"probes", std::move(probes)},
                         {"other", options_.other.empty() ? Json() : Json(options_.other)}};
  const std::vector<TaskLoad> loads = loads_of(conditions_, settings_.episodes);
  for (std::size_t i = 0; i < loads.size(); ++i) {
    header.tasks.push_back({record_name(conditions_[i]), loads[i]});
  }
  return header;
}

Json ProbeRun::play(Ranks& ranks, const ProbeProgress& progress, const EpisodeStore& store) {
  if (ranks.is_root() && !options_.output.empty()) require_writable_folder(options_.output);
  ConditionPlayer player(conditions_, protocol_, worker_threads(protocol_.threads, ranks));
  ProbeSource source(conditions_, protocol_, progress, store);
  distribute_work(
      ranks, protocol_.threads,
      [&player](const WorkItem& item, const WorkContext& context) { player.play(item, context); },
      source);
  const bool whole = store.shard.count == 1;
  return ranks.is_root() && whole ? document(source.results()) : Json();
}

Json ProbeRun::document(const std::vector<ConditionResults>& results) const {
  JsonList documents;
  for (const TaskSections& task : tasks_) {
    JsonTable document{{"env_id", task.entry->id},
                       {"family", task.entry->family},
                       {"memory_type", task.entry->memory_type}};
    for (const TaskSections::Section& section : task.sections) {
      const auto first = results.begin() + static_cast<std::ptrdiff_t>(section.first);
      document.emplace_back(
          name_of(section.probe),
          section.plan.document(
              {first, first + static_cast<std::ptrdiff_t>(section.plan.conditions.size())}));
    }
    documents.emplace_back(std::move(document));
  }
  return JsonTable{{"settings", settings_.document()},
                   {"other", options_.other.empty() ? Json() : Json(options_.other)},
                   {"tasks", std::move(documents)}};
}

Json run_probes(const EvaluationSettings& settings, const Protocol& protocol,
                const ProbeOptions& options, const ProbeProgress& progress) {
  Ranks alone;
  return ProbeRun(settings, protocol, options).play(alone, progress);
}

}  // namespace engram
