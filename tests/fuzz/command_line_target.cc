// Arguments of a command line: numbers, names, pins, options.
#include "apps/command_line.h"
#include "apps/options.h"
#include "core/task/task_option.h"
#include "tests/fuzz/input.h"

namespace engram::fuzz {
namespace {

struct Words {
  std::string id;
  MakeOptions env;
  apps::TaskFilter filter;
  Policy policy = Policy::kZero;
  std::uint64_t seed = 0;
  bool json = false;
};

// False if help is asked for.
bool parse(const std::vector<std::string>& words, Words& out) {
  static constexpr Policy kPolicies[] = {Policy::kZero, Policy::kOracle};
  apps::CommandLine line("fuzz", "fuzz");
  const apps::Command command = line.program();
  command.add_option("id", out.id, "");
  apps::add_num_envs(command, out.env.num_envs);
  apps::add_threads(command, out.env.threads);
  apps::add_seed(command, out.env.seed, "");
  apps::add_policy(command, out.policy, kPolicies);
  apps::add_obs(command, out.env, apps::kAllObsModes);
  apps::add_env_options(command, out.env);
  apps::add_filter(command, out.filter);
  apps::add_json(command, out.json);
  return line.parse(words).empty();
}

// Checks of parsed values.
void use(const Words& words) {
  require(words.env.num_envs >= 1 && words.env.num_envs <= kMaxNumEnvs, "num_envs");
  require(words.env.threads >= 0 && words.env.threads <= kMaxThreads, "threads");
  (void)apps::select(words.filter);
  const RegistryEntry& entry = require_entry(words.id);
  const std::unique_ptr<Task> task = make_task(entry.id);
  (void)option_values(task->info().options, words.env.task_options, words.env.rules);
  ColumnStore store(1);
  const PinTable table(store, task->info().random_variables);
  table.check(words.env.pins);
  table.set(0, words.env.pins);
}

}  // namespace

void fuzz_command_line(Data data) {
  std::vector<std::string> words;
  std::string_view rest = Input(data).rest_text();
  while (!rest.empty() && words.size() < 12) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    words.emplace_back(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  Words out;
  accepted([&] {
    if (parse(words, out)) use(out);
  });
}

}  // namespace engram::fuzz
