#include "apps/list_command.h"

#include <fmt/format.h>

#include <memory>

#include "apps/json.h"
#include "apps/options.h"
#include "apps/output.h"
#include "protocol/batch/task_description.h"

namespace engram::apps {
namespace {

struct ListOptions {
  TaskFilter filter;
  bool json = false;
};

void run(const ListOptions& options) {
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
  for (const Json& task : to_json(tasks)) {
    table.add({task["id"], task["split"], task["memory_type"], task["horizon"].dump(),
               task["state_dim"].dump(), task["candidates"].dump()});
  }
  print(table.text() + fmt::format("{} tasks\n", tasks.size()));
}

}  // namespace

void add_list_command(CLI::App& app) {
  const auto options = std::make_shared<ListOptions>();
  CLI::App* command = app.add_subcommand("list", "The registered tasks");
  add_filter(*command, options->filter);
  add_json(*command, options->json);
  command->final_callback([options] { run(*options); });
}

}  // namespace engram::apps
