#include "apps/rollout_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "apps/digest.h"
#include "apps/episode_log.h"
#include "apps/options.h"
#include "apps/output.h"
#include "apps/progress.h"
#include "apps/task_choice.h"
#include "core/base/join.h"
#include "core/batch/queries.h"
#include "core/batch/scripted_policy.h"
#include "protocol/io/json.h"
#include "protocol/make/physics_keys.h"

namespace engram::apps {
namespace {

constexpr int kDefaultSteps = 200;
constexpr int kDefaultEnvs = 256;

struct RolloutOptions {
  std::vector<std::string> ids;
  MakeOptions env = batch_options(kDefaultEnvs, 0);
  int num_envs = 0;  // 0: not given
  int steps = 0;     // 0: not given
  int episodes = 0;  // 0: not given
  Policy policy = Policy::kRandom;
  bool hash = false;
  bool json = false;
};

// One task's part of a rollout.
struct TaskLog {
  TaskLog(const Batch& given, const RolloutOptions& options)
      : batch(given), episodes(given, options.episodes) {
    if (options.hash) digest.emplace(given.num_envs());
  }
  std::optional<std::uint64_t> hash() const {
    return digest ? std::optional(digest->value()) : std::nullopt;
  }

  const Batch& batch;
  EpisodeLog episodes;
  std::optional<Digest> digest;
};

struct RolloutReport {
  int steps = 0;
  double wall_seconds = 0;  // acting, stepping and accounting
  double step_seconds = 0;  // stepping alone
};

using Clock = std::chrono::steady_clock;

double seconds(Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

// Logs of all tasks together.
class RolloutLog {
 public:
  RolloutLog(const Batch& group, const RolloutOptions& options) {
    for (int i = 0; i < group.num_parts(); ++i) tasks_.emplace_back(group.part(i), options);
  }

  void count() {
    for (TaskLog& task : tasks_) task.episodes.update(task.batch);
  }
  void digest() {
    for (TaskLog& task : tasks_) {
      if (task.digest) task.digest->update(task.batch);
    }
  }
  bool complete() const {
    return std::ranges::all_of(tasks_,
                               [](const TaskLog& task) { return task.episodes.complete(); });
  }
  double fraction() const {
    double least = 1;
    for (const TaskLog& task : tasks_) least = std::min(least, task.episodes.fraction());
    return least;
  }

  const std::vector<TaskLog>& tasks() const { return tasks_; }
  std::int64_t env_steps() const { return sum(&EpisodeLog::env_steps); }
  std::int64_t episodes() const { return sum(&EpisodeLog::episodes); }
  // Means over all episodes; not a number if there are none.
  double success_rate() const { return mean(&EpisodeLog::success_rate); }
  double mean_return() const { return mean(&EpisodeLog::mean_return); }
  // Hash of all environments, in their order.
  std::optional<std::uint64_t> hash() const {
    std::vector<std::uint64_t> hashes;
    for (const TaskLog& task : tasks_) {
      if (!task.digest) return std::nullopt;
      const std::vector<std::uint64_t>& own = task.digest->of_environments();
      hashes.insert(hashes.end(), own.begin(), own.end());
    }
    return bench::hash_of(hashes);
  }

 private:
  std::int64_t sum(std::int64_t (EpisodeLog::*value)() const) const {
    std::int64_t all = 0;
    for (const TaskLog& task : tasks_) all += (task.episodes.*value)();
    return all;
  }
  double mean(double (EpisodeLog::*value)() const) const {
    double total = 0;
    for (const TaskLog& task : tasks_) {
      const auto episodes = static_cast<double>(task.episodes.episodes());
      if (episodes > 0) total += episodes * (task.episodes.*value)();
    }
    return total / static_cast<double>(episodes());
  }

  std::vector<TaskLog> tasks_;
};

// Steps the environments until the log is complete or the steps are used up.
RolloutReport roll_out(Batch& group, const RolloutOptions& options, RolloutLog& log) {
  RolloutReport report;
  std::vector<float> actions(static_cast<std::size_t>(group.num_envs()) *
                             static_cast<std::size_t>(group.action_dim()));
  const ScriptedPolicy policy(group, options.policy);
  Progress progress("rollout", "env steps");

  group.reset();
  log.digest();
  Clock::duration wall{};
  Clock::duration stepping{};
  while (report.steps < options.steps && !log.complete()) {
    const Clock::time_point start = Clock::now();
    policy.act(actions);
    const Clock::time_point acted = Clock::now();
    group.step(actions);
    stepping += Clock::now() - acted;
    log.count();
    ++report.steps;
    wall += Clock::now() - start;

    log.digest();
    progress.update(std::max(static_cast<double>(report.steps) / options.steps, log.fraction()),
                    static_cast<double>(log.env_steps()));
  }
  report.wall_seconds = seconds(wall);
  report.step_seconds = seconds(stepping);
  return report;
}

double images_per_step(const BatchOptions& options) {
  return observes_images(options.obs_mode) ? static_cast<double>(options.images.cameras.size())
                                           : 0.0;
}

double rate(double count, double time) { return time > 0 ? count / time : 0; }

Json hash_document(std::optional<std::uint64_t> hash) {
  return hash ? Json(fmt::format("{:016x}", *hash)) : Json();
}

JsonTable to_document(const Batch& group, const RolloutOptions& options, const RolloutLog& log,
                      const RolloutReport& report) {
  const BatchOptions& common = group.part(0).options();
  const double env_rate = rate(static_cast<double>(log.env_steps()), report.wall_seconds);
  JsonTable document = {{"id", join(options.ids, {}, "+")},
                        {"num_envs", group.num_envs()},
                        {"steps", report.steps},
                        {"threads", group.threads()},
                        {"obs", name_of(common.obs_mode)},
                        {"policy", name_of(options.policy)},
                        {"renderer", renderer_name(common)},
                        {"rules", name_of(common.rules)},
                        {"env_steps_per_second", env_rate},
                        {"physics_steps_per_second", env_rate * common.substeps},
                        {"images_per_second", env_rate * images_per_step(common)},
                        {"episodes", log.episodes()},
                        {"success_once", log.success_rate()},
                        {"mean_return", log.mean_return()},
                        {"unstable", Queries(group).unstable_count()},
                        {"hash", hash_document(log.hash())},
                        {"wall_seconds", report.wall_seconds}};
  Json mujoco = mujoco_version_of(common.physics);
  if (!is_null(mujoco)) {
    document.emplace_back(kPhysicsKey, name_of(common.physics));
    document.emplace_back(kMujocoVersionKey, std::move(mujoco));
  }
  if (!group.is_common()) return document;
  JsonList tasks;
  for (const TaskLog& task : log.tasks()) {
    tasks.emplace_back(JsonTable{{"id", task.batch.info().id},
                                 {"num_envs", task.batch.num_envs()},
                                 {"episodes", task.episodes.episodes()},
                                 {"success_once", task.episodes.success_rate()},
                                 {"mean_return", task.episodes.mean_return()},
                                 {"unstable", Queries(task.batch).unstable_count()},
                                 {"hash", hash_document(task.hash())}});
  }
  document.emplace_back("tasks", std::move(tasks));
  return document;
}

std::string episodes_in_words(std::int64_t episodes, double success, double mean_return,
                              int horizon) {
  if (episodes == 0) return fmt::format("none finished (one takes up to {} steps)", horizon);
  return fmt::format("{}: success_once {:.3f}, mean return {:.3f}",
                     with_thousands(static_cast<double>(episodes)), success, mean_return);
}

std::string to_plain_text(const Batch& group, const RolloutOptions& options, const RolloutLog& log,
                          const RolloutReport& report) {
  const BatchOptions& common = group.part(0).options();
  const auto env_steps = static_cast<double>(log.env_steps());
  const double env_rate = rate(env_steps, report.wall_seconds);
  const std::string name =
      options.ids.size() == 1 ? options.ids.front() : fmt::format("{} tasks", options.ids.size());
  std::string text = fmt::format(
      "{}: {} environments x {} steps, {} threads, policy {}\n"
      "  env steps       {} in {:.3f} s\n"
      "  env steps/s     {} ({} for stepping alone, without the policy)\n"
      "  physics steps/s {}\n",
      name, group.num_envs(), report.steps, group.threads(), name_of(options.policy),
      with_thousands(env_steps), report.wall_seconds, with_thousands(env_rate),
      with_thousands(rate(env_steps, report.step_seconds)),
      with_thousands(env_rate * common.substeps));
  if (const double images = images_per_step(common); images > 0) {
    text += fmt::format("  images/s        {}\n", with_thousands(env_rate * images));
  }
  text += fmt::format(
      "  episodes        {}\n",
      episodes_in_words(log.episodes(), log.success_rate(), log.mean_return(), group.horizon()));
  const std::uint64_t unstable = Queries(group).unstable_count();
  if (unstable > 0) text += fmt::format("  unstable steps  {}\n", unstable);
  if (log.hash()) text += fmt::format("  hash            {:016x}\n", *log.hash());
  if (!group.is_common()) return text;
  for (const TaskLog& task : log.tasks()) {
    text += fmt::format("  {} x {}: {}\n", task.batch.num_envs(), task.batch.info().id,
                        episodes_in_words(task.episodes.episodes(), task.episodes.success_rate(),
                                          task.episodes.mean_return(), task.batch.info().horizon));
  }
  return text;
}

// Fills in the options that were not given.
RolloutOptions completed(RolloutOptions options) {
  const auto tasks = static_cast<int>(options.ids.size());
  if (options.num_envs > 0) {
    options.env.num_envs = options.num_envs;
  } else if (options.episodes > 0) {
    options.env.num_envs = std::min(kDefaultEnvs, options.episodes * tasks);
  }
  if (options.env.num_envs < tasks) {
    throw Error(Error::kInvalidArgument,
                fmt::format("--num-envs: {} given for {} tasks, {} and more allowed",
                            options.env.num_envs, tasks, tasks));
  }
  if (options.steps == 0) {
    options.steps = options.episodes > 0 ? std::numeric_limits<int>::max() : kDefaultSteps;
  }
  if (options.env.auto_reset == AutoReset::kOff &&
      options.episodes > options.env.num_envs / tasks) {
    throw Error(
        Error::kInvalidArgument,
        fmt::format("--episodes: {} given; with --auto-reset off each of the {} "
                    "environments runs one, so up to {} allowed",
                    options.episodes, options.env.num_envs / tasks, options.env.num_envs / tasks));
  }
  return options;
}

// One task, or several that share the environments evenly.
std::unique_ptr<Batch> make_group(const RolloutOptions& options) {
  if (options.ids.size() == 1) {
    return make(options.ids.front(), options.env);
  }
  const auto tasks = static_cast<int>(options.ids.size());
  std::vector<TaskShare> shares;
  for (int i = 0; i < tasks; ++i) {
    const int extra = i < options.env.num_envs % tasks ? 1 : 0;
    shares.push_back(
        {options.ids[static_cast<std::size_t>(i)], options.env.num_envs / tasks + extra});
  }
  return engram::make_group(shares, options.env);
}

void run(const RolloutOptions& given) {
  const RolloutOptions options = completed(given);
  const auto group = make_group(options);
  for (const std::string& id : options.ids) warn_of_constants(id, options.env);
  RolloutLog log(*group, options);
  const RolloutReport report = roll_out(*group, options, log);
  print(options.json ? to_text(to_document(*group, options, log, report))
                     : to_plain_text(*group, options, log, report));
}

}  // namespace

void add_rollout_command(const Command& program) {
  const auto options = std::make_shared<RolloutOptions>();
  const Command command = program.add_command("rollout", "Batched rollouts of one task or several");
  command
      .add_option("ids", options->ids,
                  "The task, such as RememberColor9-VLA-v0, or several in one batch")
      .required()
      .type_name("ID");
  add_num_envs(command, options->num_envs)
      .description(
          "Environments stepped together, shared evenly by the tasks; with --episodes, by "
          "default no more than E for each task")
      .default_str(std::to_string(kDefaultEnvs));
  add_int(command, "--steps", options->steps, 1, std::numeric_limits<int>::max(),
          "Control steps per environment; with --episodes, at most")
      .type_name("T")
      .default_str(std::to_string(kDefaultSteps));
  add_int(command, "--episodes", options->episodes, 1, std::numeric_limits<int>::max(),
          "Runs until E episodes of each task are finished: as many of each environment, give or "
          "take one")
      .type_name("E")
      .default_str("");
  add_seed(command, options->env.seed, "Environment i of a task begins with seed + i");
  add_threads(command, options->env.threads);
  add_lanes(command, options->env.lanes);
  add_obs(command, options->env, kAllObsModes);
  add_policy(command, options->policy, kTaskPolicies);
  add_env_options(command, options->env);
  command.add_flag("--hash", options->hash,
                   "Digest of every observation, reward, termination and truncation");
  add_json(command, options->json);
  command.footer(
      "env_steps_per_second counts the wall time of policy, stepping and accounting "
      "(wall_seconds), "
      "not that of creation, the first reset and --hash. A step in which an environment starts "
      "over "
      "(--auto-reset next-step) or stands still (off) is no environment step.\n"
      "success_once and mean_return are over the finished episodes; null if there is none.");
  command.on_run([options] { run(*options); });
}

}  // namespace engram::apps
