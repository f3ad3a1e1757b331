#include "apps/list_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "apps/options.h"
#include "apps/output.h"
#include "protocol/make/benchmark_csv.h"
#include "protocol/make/task_description.h"

namespace engram::apps {
namespace {

struct ListOptions {
  TaskFilter filter;
  bool json = false;
  bool csv = false;
};

void print_csv(const std::vector<const RegistryEntry*>& entries) {
  if (std::ranges::none_of(entries, &RegistryEntry::canonical)) {
    throw Error(Error::kInvalidArgument,
                "--csv: filters that leave no task of the canonical benchmark given; its 90 tasks "
                "are those of --split short, medium and long");
  }
  print(benchmark_csv(entries));
}

void run(const ListOptions& options) {
  if (options.csv) return print_csv(select(options.filter));
  ConstantList tasks;
  for (const RegistryEntry* entry : select(options.filter)) {
    tasks.emplace_back(describe_entry(*entry));
  }
  if (options.json) {
    print(to_text(tasks));
    return;
  }
  Table table({{"id"},
               {"split"},
               {"memory type"},
               {"horizon", true},
               {"state", true},
               {"candidates", true}});
  for (const Json& task : tasks) {
    const auto cell = [&task](const char* key) { return text(part(task, key)); };
    const auto count = [&task](const char* key) { return to_line(part(task, key)); };
    table.add({cell("id"), cell("split"), cell("memory_type"), count("horizon"), count("state_dim"),
               count("candidates")});
  }
  const auto rl = std::ranges::count_if(
      tasks, [](const Json& task) { return text(part(task, "split")) == "rl"; });
  const auto count_of = [](auto number, const char* half) {
    return number == 0 ? std::string() : fmt::format(" ({} {})", number, half);
  };
  print(table.text() + fmt::format("{} tasks{}\n", tasks.size(), count_of(rl, "of the RL half")));
}

}  // namespace

void add_list_command(const Command& program) {
  const auto options = std::make_shared<ListOptions>();
  const Command command = program.add_command("list", "The registered tasks");
  add_filter(command, options->filter);
  const Option json = add_json(command, options->json);
  command
      .add_flag("--csv", options->csv,
                "The canonical benchmark's tasks as mikasa_robo_vla_envs.csv has them, with "
                "semicolons between the columns")
      .excludes(json);
  command.on_run([options] { run(*options); });
}

}  // namespace engram::apps
