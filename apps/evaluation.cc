#include "apps/evaluation.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <string>

#include "apps/options.h"

namespace engram::apps {
namespace {

template <class T>
double mean(const std::vector<T>& values) {
  if (values.empty()) return 0;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

// As result files spell it; tasks outside the benchmark's splits are "Custom".
std::string title(Split split) {
  switch (split) {
    case Split::kShort:
      return "Short";
    case Split::kMedium:
      return "Medium";
    case Split::kLong:
      return "Long";
    case Split::kExtended:
      break;
  }
  return "Custom";
}

bool all_finished(const VectorEnv& env) {
  for (std::size_t i = 0; i < env.terminated().size(); ++i) {
    if ((env.terminated()[i] | env.truncated()[i]) == 0) return false;
  }
  return true;
}

// Starts the episodes of seeds first, first + 1, ... in the first `count` environments; the others,
// finished in the batch before, stay as they are.
void start_batch(VectorEnv& env, std::uint64_t first, int count) {
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(env.num_envs()), 0);
  std::fill_n(mask.begin(), count, std::uint8_t{1});
  std::vector<std::uint64_t> seeds(mask.size());
  std::iota(seeds.begin(), seeds.end(), first);
  env.reset({.mask = mask, .seeds = seeds, .pins = nullptr});
}

void collect(const VectorEnv& env, int count, TaskResult& result) {
  const auto value = [&env]<class T>(const char* name, int i, T) {
    return *reinterpret_cast<const T*>(env.output(name).row(i));
  };
  for (int i = 0; i < count; ++i) {
    result.successes.push_back(value("success_once", i, std::uint8_t{}) != 0);
    result.returns.push_back(value("episode_return", i, double{}));
    result.lengths.push_back(value("elapsed_steps", i, std::int32_t{}));
  }
}

}  // namespace

double TaskResult::success_rate() const { return mean(successes); }
double TaskResult::mean_return() const { return mean(returns); }
double TaskResult::mean_length() const { return mean(lengths); }

TaskResult evaluate(const RegistryEntry& entry, const Protocol& protocol,
                    const std::function<void(double)>& progress) {
  EnvOptions options =
      batch_options(std::min(protocol.num_envs, protocol.episodes), protocol.threads);
  options.auto_reset = AutoReset::kOff;
  options.obs_mode = protocol.observation.obs_mode;
  options.image_options = protocol.observation.image_options;
  const auto env = make(entry.id, options);
  std::vector<float> actions(static_cast<std::size_t>(env->num_envs()) *
                             static_cast<std::size_t>(env->action_dim()));
  TaskResult result;
  result.entry = &entry;
  result.chance = env->info().chance();
  const double steps_of_all =
      static_cast<double>(protocol.episodes) * static_cast<double>(entry.horizon);
  for (int done = 0; done < protocol.episodes; done += env->num_envs()) {
    const int count = std::min(env->num_envs(), protocol.episodes - done);
    start_batch(*env, protocol.start_seed + static_cast<std::uint64_t>(done), count);
    for (int step = 0; !all_finished(*env); ++step) {
      env->act(protocol.policy, actions);
      env->step(actions);
      progress((static_cast<double>(done) * entry.horizon + static_cast<double>(step) * count) /
               steps_of_all);
    }
    collect(*env, count, result);
  }
  for (int i = 0; i < protocol.episodes; ++i) {
    result.seeds.push_back(protocol.start_seed + static_cast<std::uint64_t>(i));
  }
  result.unstable = env->unstable_count();
  return result;
}

Json task_document(const TaskResult& result, const Protocol& protocol) {
  const RegistryEntry& entry = *result.entry;
  return {{"env_id", entry.id},
          {"split", title(entry.split)},
          {"memory_type", entry.memory_type},
          {"start_seed", protocol.start_seed},
          {"n_episodes", protocol.episodes},
          {"successes", result.successes},
          {"returns", result.returns},
          {"sr", result.success_rate()},
          {"mean_return", result.mean_return()},
          {"chance", result.chance},
          {"benchmark_commit", nullptr},
          {"control_mode", control_mode_name(ControlMode::kPdEeDeltaPose)},
          {"obs_mode", obs_name(protocol.observation)},
          {"wrapper_chain", "apply_mikasa_vla_wrappers(include_overlays=False)"},
          {"action_chunk_size", 1},
          {"model",
           {{"name", policy_name(protocol.policy)},
            {"config", {{"library", "engram"}, {"version", version()}}}}},
          {"episode_lengths", result.lengths},
          {"episode_seeds", result.seeds}};
}

Json summary_document(const std::vector<TaskResult>& results) {
  std::string split;
  std::vector<double> rates;
  std::map<std::string, std::vector<double>> rates_of_type;  // sorted by name
  Json tasks = Json::array();
  Json per_task_rate = Json::object();
  Json per_task_return = Json::object();
  for (const TaskResult& result : results) {
    const std::string id(result.entry->id);
    const std::string own = title(result.entry->split);
    split = split.empty() || split == own ? own : "Custom";
    rates.push_back(result.success_rate());
    rates_of_type[std::string(result.entry->memory_type)].push_back(rates.back());
    tasks.push_back(id);
    per_task_rate[id] = rates.back();
    per_task_return[id] = result.mean_return();
  }
  Json per_type = Json::object();
  for (const auto& [type, values] : rates_of_type) per_type[type] = mean(values);
  return {
      {"split", split}, {"sr_split", mean(rates)},      {"sr_per_memory_type", per_type},
      {"tasks", tasks}, {"per_task_sr", per_task_rate}, {"per_task_mean_return", per_task_return}};
}

}  // namespace engram::apps
