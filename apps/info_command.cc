#include "apps/info_command.h"

#include <fmt/format.h>

#include <memory>

#include "apps/options.h"
#include "apps/output.h"
#include "apps/task_choice.h"
#include "apps/task_text.h"
#include "core/batch/queries.h"
#include "protocol/io/files.h"
#include "protocol/make/task_description.h"

namespace engram::apps {
namespace {

struct InfoOptions {
  std::string id;
  std::string mjcf;  // file to write the scene to; "-": standard output
  MakeOptions env = batch_options(1, 1);
  bool json = false;
};

void run(const InfoOptions& options) {
  if (options.mjcf == "-" && options.json) {
    throw Error(Error::kInvalidArgument,
                "--mjcf: '-' given with --json; standard output takes one of them, so a file name "
                "is needed");
  }
  const auto batch = make(options.id, options.env);
  if (!options.mjcf.empty()) batch->reset();
  warn_of_constants(options.id, options.env);
  if (options.mjcf == "-") {
    print(Queries(*batch).drawn_document(0));
    return;
  }
  if (!options.mjcf.empty()) write_output(options.mjcf, Queries(*batch).drawn_document(0));
  const ConstantTable description = describe_task(*batch);
  print(options.json ? to_text(description) : task_text(description));
}

}  // namespace

void add_info_command(const Command& program) {
  const auto options = std::make_shared<InfoOptions>();
  const Command command = program.add_command("info", "One task in full");
  command.add_option("id", options->id, "The task, such as RememberColor9-VLA-v0")
      .required()
      .type_name("ID");
  command
      .add_option("--mjcf", options->mjcf,
                  "Also writes the scene of an episode's begin as MJCF to FILE (-: to standard "
                  "output, instead), for MuJoCo's own step")
      .type_name("FILE");
  add_seed(command, options->env.seed, "Seed of that episode");
  add_pins(command, options->env.pins);
  add_layout(command, options->env.obs_mode);
  add_constants(command, options->env.constants);
  add_rules(command, options->env.rules);
  add_task_options(command, options->env.task_options,
                   "Chooses a variant of the task's rules (repeatable)");
  add_json(command, options->json);
  command.on_run([options] { run(*options); });
}

}  // namespace engram::apps
