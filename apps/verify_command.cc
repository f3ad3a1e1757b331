#include "apps/verify_command.h"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <utility>

#include "apps/options.h"
#include "apps/output.h"
#include "apps/progress.h"
#include "apps/task_choice.h"
#include "bench/bit_identity.h"
#include "core/batch/scripted_policy.h"
#include "protocol/io/json.h"

namespace engram::apps {
namespace {

constexpr int kMaxSteps = 10'000;

struct VerifyOptions {
  std::vector<std::string> ids;
  TaskFilter filter;
  std::optional<ObsMode> obs_mode;  // empty: kObsModes
  bench::IdentityOptions identity;
  MakeOptions env;  // control mode, proprio, physics, constants and perturbations
  bool json = false;
};

struct TaskCheck {
  std::string id;
  ObsMode obs_mode = ObsMode::kState;
  bench::IdentityResult result;
};

std::vector<TaskCheck> check_all(const VerifyOptions& options) {
  std::vector<ObsMode> modes(kObsModes.begin(), kObsModes.end());
  if (options.obs_mode) modes = {*options.obs_mode};
  const bool all = options.ids.empty() && !options.filter.any();
  const std::vector<const RegistryEntry*> tasks =
      all ? select({}) : chosen_tasks(options.ids, options.filter, false);
  std::vector<TaskCheck> rows;
  for (const ObsMode mode : modes) {
    for (const RegistryEntry* task : tasks) {
      rows.push_back({std::string(task->id), mode, {}});
    }
  }
  Progress progress("verify", "env steps");
  bench::IdentityOptions identity = options.identity;
  identity.make_batch = [&options](InstructionSet set, const std::string& id, MakeOptions batch) {
    batch.constants = options.env.constants;
    batch.perturbations = options.env.perturbations;
    batch.control_mode = options.env.control_mode;
    batch.joint_proprio = options.env.joint_proprio;
    batch.physics = options.env.physics;
    return bench::make_on(set, id, batch);
  };
  double done = 0;
  double env_steps = 0;
  identity.progress = [&](double fraction) {
    progress.update((done + fraction) / static_cast<double>(rows.size()), env_steps);
  };
  for (TaskCheck& row : rows) {
    identity.obs_mode = row.obs_mode;
    row.result = bench::check_identity(row.id, identity);
    ++done;
    env_steps += static_cast<double>(row.result.env_steps);
  }
  return rows;
}

std::string hex(std::uint64_t number) { return fmt::format("{:016x}", number); }

JsonTable describe(const TaskCheck& row) {
  return {{"id", row.id},
          {"obs", name_of(row.obs_mode)},
          {"plays", row.result.runs},
          {"episodes", row.result.episodes},
          {"env_steps", row.result.env_steps},
          {"different", row.result.different},
          {"fingerprint", hex(row.result.fingerprint)}};
}

std::string to_plain_text(const std::vector<TaskCheck>& rows) {
  Table table({{"id"},
               {"obs"},
               {"plays", true},
               {"episodes", true},
               {"env steps", true},
               {"different", true},
               {"fingerprint"}});
  for (const TaskCheck& row : rows) {
    table.add({row.id, name_of(row.obs_mode), std::to_string(row.result.runs),
               with_thousands(static_cast<double>(row.result.episodes)),
               with_thousands(static_cast<double>(row.result.env_steps)),
               with_thousands(static_cast<double>(row.result.different)),
               hex(row.result.fingerprint)});
  }
  return table.text();
}

void run(const VerifyOptions& options) {
  if (options.env.control_mode) require_mode_of(Policy::kOracle, *options.env.control_mode);
  const std::vector<TaskCheck> rows = check_all(options);
  JsonList document;
  document.reserve(rows.size());
  std::size_t different = 0;
  for (const TaskCheck& row : rows) {
    document.emplace_back(describe(row));
    if (row.result.different > 0) ++different;
  }
  print(options.json ? to_text(document) : to_plain_text(rows));
  if (different > 0) {
    throw Error(Error::kInternal, fmt::format("{} of {} checks found different bits; none allowed",
                                              different, rows.size()));
  }
}

}  // namespace

void add_verify_command(const Command& program) {
  const auto options = std::make_shared<VerifyOptions>();
  const Command command =
      program.add_command("verify", "Checks that the same seeds give the same bits, however run");
  command.add_option("ids", options->ids, "Tasks, such as RememberColor9-VLA-v0; default: all")
      .type_name("ID");
  add_filter(command, options->filter);
  add_obs_mode(command, options->obs_mode, kAllObsModes).default_str("state, rgb and objects");
  add_int(command, "--steps", options->identity.steps, 1, kMaxSteps,
          "Control steps of each segment")
      .type_name("T");
  add_control_mode(command, options->env.control_mode);
  add_joint_proprio(command, options->env.joint_proprio);
  add_physics(command, options->env.physics);
  add_constants(command, options->env.constants);
  add_perturbations(command, options->env.perturbations);
  add_seed(command, options->identity.seed, "The first of 64 seeds");
  add_json(command, options->json);
  command.footer(fmt::format(
      "Each task runs {} segments of episodes, with random actions and the oracle's, in one batch "
      "of "
      "64 on one thread; then again in {} configurations, with 1 to 8 threads, batches of 64, 7 "
      "and "
      "1, other chunks, shuffled slots, and every instruction set of the machine. Every output, "
      "image and memory value of every step must be the same to the bit; otherwise the exit code "
      "is "
      "1. See docs/determinism.md.",
      bench::kSegments, bench::run_configs().size()));
  command.on_run([options] { run(*options); });
}

}  // namespace engram::apps
