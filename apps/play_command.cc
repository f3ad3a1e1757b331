#include "apps/play_command.h"

#include "apps/options.h"
#include "apps/policy_server.h"
#include "apps/python_module.h"
#include "core/base/error.h"

namespace engram::apps {
namespace {

struct PlayOptions {
  std::vector<std::string> arguments;  // checked by Python
};

// Becomes the server.
[[noreturn]] void run(const PlayOptions& options, const std::vector<std::string>& task_options) {
  std::vector<std::string> words = python_words("engram.play", "play");
  words.insert(words.end(), task_options.begin(), task_options.end());
  words.insert(words.end(), options.arguments.begin(), options.arguments.end());
  become(std::move(words), "play");
}

}  // namespace

void add_play_command(const Command& program,
                      const std::shared_ptr<const std::vector<std::string>>& task_options) {
  const auto options = std::make_shared<PlayOptions>();
  const Command command = program.add_command(
      "play", "Opens a page in the browser to choose, play and watch episodes (docs/play.md)");
  const auto pass_on = [options](const std::string& name) {
    return [options, name](const std::string& value) {
      if (value.empty()) throw Error(Error::kInvalidArgument, name + ": '' given, a text needed");
      options->arguments.push_back(name + "=" + value);
    };
  };
  command
      .add_option(
          "id",
          [options](const std::string& id) {
            if (id.empty())
              throw Error(Error::kInvalidArgument, "id: '' given, a task's id needed");
            options->arguments.push_back(id);
          },
          "The task to begin with, such as RememberColor9-VLA-v0; default: the page asks")
      .type_name("ID");
  command.add_option("--port", pass_on("--port"), "Port to listen at; default: one that is free")
      .type_name("INT");
  command
      .add_option("--host", pass_on("--host"),
                  "Address to listen at; default: 127.0.0.1, this machine alone")
      .type_name("ADDRESS");
  command.add_flag(
      "--no-open", [options] { options->arguments.emplace_back("--no-open"); },
      "Prints the page's address and opens no browser");
  command
      .add_option("--out", pass_on("--out"),
                  "Folder of recorded episodes: DIR/data_npz/<id>; default: played")
      .type_name("DIR");
  command
      .add_repeatable("--folder", pass_on("--folder"),
                      "Demonstrations or results to view (repeatable)")
      .type_name("DIR");
  const Option process = command.add_option("--policy-command", pass_on("--policy-command"),
                                            "A policy's process to watch, as of eval");
  process.type_name("COMMAND");
  const Option server = add_policy_server(command, pass_on("--policy-server"));
  server.excludes(process);
  const auto take = [pass_on](const std::string& name, const std::string& value) {
    pass_on(name)(value);
  };
  add_server_options(command, server, take);
  for (const Option& option : add_chunk_options(command, take)) option.needs(server);
  command
      .add_option("--policy-timeout", pass_on("--policy-timeout"),
                  "Seconds for every answer of that process or server; default: 300")
      .type_name("INT");
  command.add_option("--obs", pass_on("--obs"), "What it observes: rgb (default), objects or state")
      .type_name("MODE");
  command
      .add_repeatable(
          "--perturb",
          [pass_on](const std::string& text) {
            (void)parse_perturbation(text);
            pass_on("--perturb")(text);
          },
          "How far episodes depart from the usual scene, as of eval (repeatable)")
      .type_name("AXIS=LEVEL");
  command
      .add_option("--physics", pass_on("--physics"),
                  "Engine that moves robot and props, as of eval; default: engram")
      .type_name("engram|mujoco");
  command.add_flag(
      "--choices", [options] { options->arguments.emplace_back("--choices"); },
      "Begins with answers by name: the page asks, a scripted hand acts (docs/choices.md)");
  command.add_flag(
      "--stay", [options] { options->arguments.emplace_back("--stay"); },
      "Keeps running when the page is closed, until Ctrl-C");
  command.on_run([options, task_options] { run(*options, *task_options); });
}

}  // namespace engram::apps
