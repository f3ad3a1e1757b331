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
#include "core/env/queries.h"
#include "core/env/scripted_policy.h"
#include "protocol/formats/document.h"

namespace engram::apps {
namespace {

constexpr int kDefaultSteps = 200;
constexpr int kDefaultEnvs = 256;

struct RolloutOptions {
  std::string id;
  MakeOptions env = batch_options(kDefaultEnvs, 0);
  int num_envs = 0;  // 0: not given
  int steps = 0;     // 0: not given
  int episodes = 0;  // 0: not given
  Policy policy = Policy::kRandom;
  bool hash = false;
  bool json = false;
};

struct RolloutReport {
  int steps = 0;
  double wall_seconds = 0;  // acting, stepping and accounting
  double step_seconds = 0;  // stepping alone
  std::optional<std::uint64_t> hash;
};

using Clock = std::chrono::steady_clock;

double seconds(Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

// Steps the batch until the log is complete or the steps are used up.
RolloutReport roll_out(Batch& env, const RolloutOptions& options, EpisodeLog& log) {
  RolloutReport report;
  std::vector<float> actions(static_cast<std::size_t>(env.num_envs()) *
                             static_cast<std::size_t>(env.action_dim()));
  std::optional<Digest> digest;
  if (options.hash) digest.emplace(env.num_envs());
  Progress progress("rollout", "env steps");

  env.reset();
  if (digest) digest->update(env);
  Clock::duration wall{};
  Clock::duration stepping{};
  while (report.steps < options.steps && !log.complete()) {
    const Clock::time_point start = Clock::now();
    ScriptedPolicy(env, options.policy).act(actions);
    const Clock::time_point acted = Clock::now();
    env.step(actions);
    stepping += Clock::now() - acted;
    log.update(env);
    ++report.steps;
    wall += Clock::now() - start;

    if (digest) digest->update(env);
    progress.update(std::max(static_cast<double>(report.steps) / options.steps, log.fraction()),
                    static_cast<double>(log.env_steps()));
  }
  report.wall_seconds = seconds(wall);
  report.step_seconds = seconds(stepping);
  if (digest) report.hash = digest->value();
  return report;
}

double images_per_step(const BatchOptions& options) {
  return observes_pictures(options.obs_mode) ? static_cast<double>(options.images.cameras.size())
                                             : 0.0;
}

double rate(double count, double time) { return time > 0 ? count / time : 0; }

DocumentTable to_document(const Batch& env, const RolloutOptions& options, const EpisodeLog& log,
                          const RolloutReport& report) {
  const double env_rate = rate(static_cast<double>(log.env_steps()), report.wall_seconds);
  const Document hash = report.hash ? Document(fmt::format("{:016x}", *report.hash)) : Document();
  return {{"id", env.info().id},
          {"num_envs", env.num_envs()},
          {"steps", report.steps},
          {"threads", env.options().threads},
          {"obs", name_of(env.options().obs_mode)},
          {"policy", name_of(options.policy)},
          {"renderer", renderer_name(env.options())},
          {"rules", name_of(env.options().rules)},
          {"env_steps_per_second", env_rate},
          {"physics_steps_per_second", env_rate * env.options().substeps},
          {"images_per_second", env_rate * images_per_step(env.options())},
          {"episodes", log.episodes()},
          {"success_once", log.success_rate()},
          {"mean_return", log.mean_return()},
          {"unstable", Queries(env).unstable_count()},
          {"hash", hash},
          {"wall_seconds", report.wall_seconds}};
}

std::string to_plain_text(const Batch& env, const RolloutOptions& options, const EpisodeLog& log,
                          const RolloutReport& report) {
  const auto env_steps = static_cast<double>(log.env_steps());
  const double env_rate = rate(env_steps, report.wall_seconds);
  std::string text = fmt::format(
      "{}: {} environments x {} steps, {} threads, policy {}\n"
      "  env steps       {} in {:.3f} s\n"
      "  env steps/s     {} ({} for stepping alone, without the policy)\n"
      "  physics steps/s {}\n",
      env.info().id, env.num_envs(), report.steps, env.options().threads, name_of(options.policy),
      with_thousands(env_steps), report.wall_seconds, with_thousands(env_rate),
      with_thousands(rate(env_steps, report.step_seconds)),
      with_thousands(env_rate * env.options().substeps));
  if (const double images = images_per_step(env.options()); images > 0) {
    text += fmt::format("  images/s        {}\n", with_thousands(env_rate * images));
  }
  if (log.episodes() > 0) {
    text += fmt::format("  episodes        {}: success_once {:.3f}, mean return {:.3f}\n",
                        with_thousands(static_cast<double>(log.episodes())), log.success_rate(),
                        log.mean_return());
  } else {
    text += fmt::format("  episodes        none finished (one takes up to {} steps)\n",
                        env.info().horizon);
  }
  const std::uint64_t unstable = Queries(env).unstable_count();
  if (unstable > 0) text += fmt::format("  unstable steps  {}\n", unstable);
  if (report.hash) text += fmt::format("  hash            {:016x}\n", *report.hash);
  return text;
}

// Fills in the options that were not given.
RolloutOptions completed(RolloutOptions options) {
  if (options.num_envs > 0) {
    options.env.num_envs = options.num_envs;
  } else if (options.episodes > 0) {
    options.env.num_envs = std::min(kDefaultEnvs, options.episodes);
  }
  if (options.steps == 0) {
    options.steps = options.episodes > 0 ? std::numeric_limits<int>::max() : kDefaultSteps;
  }
  if (options.env.auto_reset == AutoReset::kOff && options.episodes > options.env.num_envs) {
    throw Error(Error::kInvalidArgument,
                fmt::format("--episodes: {} given; with --auto-reset off each of the {} "
                            "environments runs one, so up to {} allowed",
                            options.episodes, options.env.num_envs, options.env.num_envs));
  }
  return options;
}

void run(const RolloutOptions& given) {
  const RolloutOptions options = completed(given);
  const auto env = make(options.id, options.env);
  warn_of_unused_constants(options.id, options.env);
  EpisodeLog log(*env, options.episodes);
  const RolloutReport report = roll_out(*env, options, log);
  print(options.json ? to_text(to_document(*env, options, log, report))
                     : to_plain_text(*env, options, log, report));
}

}  // namespace

void add_rollout_command(const Command& program) {
  const auto options = std::make_shared<RolloutOptions>();
  const Command command = program.add_command("rollout", "Batched rollouts of one task");
  command.add_option("id", options->id, "The task, such as RememberColor9-VLA-v0")
      .required()
      .type_name("ID");
  add_num_envs(command, options->num_envs)
      .description("Environments stepped together; with --episodes, by default no more than E")
      .default_str(std::to_string(kDefaultEnvs));
  add_int(command, "--steps", options->steps, 1, std::numeric_limits<int>::max(),
          "Control steps per environment; with --episodes, at most")
      .type_name("T")
      .default_str(std::to_string(kDefaultSteps));
  add_int(command, "--episodes", options->episodes, 1, std::numeric_limits<int>::max(),
          "Runs until E episodes are finished: as many of each environment, give or take one")
      .type_name("E")
      .default_str("");
  add_seed(command, options->env.seed, "Environment i begins with seed + i");
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
