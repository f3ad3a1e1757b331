#include "apps/list_command.h"

#include <fmt/format.h>

#include <memory>

#include "apps/json.h"
#include "apps/options.h"
#include "apps/output.h"

namespace engram::apps {
namespace {

struct ListOptions {
  TaskFilter filter;
  bool json = false;
};

Json describe(const RegistryEntry& entry) {
  constexpr int kCanonicalActionDim = 7;  // of pd_ee_delta_pose
  Json task = {{"id", entry.id},
               {"family", entry.family},
               {"split", split_name(entry.split)},
               {"memory_type", entry.memory_type},
               {"horizon", entry.horizon},
               {"canonical", entry.canonical},
               {"instruction", entry.instruction},
               {"action_dim", kCanonicalActionDim},
               {"state_dim", nullptr},
               {"candidates", nullptr},
               {"available", is_implemented(entry)}};
  if (is_implemented(entry)) {
    const auto env = make(entry.id, batch_options(1, 1));
    task["action_dim"] = env->action_dim();
    task["state_dim"] = env->state_dim();
    task["candidates"] = env->info().candidates;
  }
  return task;
}

std::string number_or_dash(const Json& value) { return value.is_null() ? "-" : value.dump(); }

void run(const ListOptions& options) {
  Json tasks = Json::array();
  for (const RegistryEntry* entry : select(options.filter)) tasks.push_back(describe(*entry));
  if (options.json) {
    print(to_text(tasks));
    return;
  }
  Table table({{"id"},
               {"split"},
               {"memory type"},
               {"horizon", true},
               {"state", true},
               {"candidates", true},
               {"available"}});
  int available = 0;
  for (const Json& task : tasks) {
    if (task["available"]) ++available;
    table.add({task["id"], task["split"], task["memory_type"], task["horizon"].dump(),
               number_or_dash(task["state_dim"]), number_or_dash(task["candidates"]),
               task["available"] ? "yes" : "-"});
  }
  print(table.text() +
        fmt::format("{} tasks, {} available in this version\n", tasks.size(), available));
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
