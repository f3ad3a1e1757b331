#include "apps/check_command.h"

#include <utility>

#include "apps/python_module.h"

namespace engram::apps {
namespace {

struct CheckOptions {
  std::vector<std::string> targets;
  std::vector<std::string> arguments;  // checked by Python
};

// Becomes the process that checks.
[[noreturn]] void run(const CheckOptions& options, const std::vector<std::string>& task_options) {
  std::vector<std::string> words = python_words("engram.kit.checks", "check");
  words.insert(words.end(), task_options.begin(), task_options.end());
  words.insert(words.end(), options.arguments.begin(), options.arguments.end());
  words.emplace_back("--");
  words.insert(words.end(), options.targets.begin(), options.targets.end());
  become(std::move(words), "check");
}

}  // namespace

void add_check_command(const Command& program,
                       const std::shared_ptr<const std::vector<std::string>>& task_options) {
  const auto options = std::make_shared<CheckOptions>();
  const Command command = program.add_command(
      "check", "Checks tasks of your own as the built-in ones are checked (docs/custom_tasks.md)");
  const auto pass_on = [options](const std::string& name) {
    return [options, name](const std::string& value) {
      options->arguments.push_back(name + "=" + value);
    };
  };
  const auto pass_flag = [options](const std::string& name) {
    return [options, name] { options->arguments.push_back(name); };
  };
  command
      .add_option("tasks", options->targets,
                  "Files of tasks, such as my_tasks.py or my_tasks.py:LampOrder-v0, and ids")
      .type_name("FILE.py[:ID]|ID")
      .required();
  command
      .add_option("--episodes", pass_on("--episodes"),
                  "Episodes of success rates; default: 200, with --fast 64")
      .type_name("INT");
  command.add_flag("--fast", pass_flag("--fast"), "Fewer episodes");
  command.add_flag("--json", pass_flag("--json"), "Prints the report as JSON");
  command
      .add_option("--hidden", pass_on("--hidden"),
                  "Draw that is hidden, if it is another one than the task names")
      .type_name("DRAW");
  command
      .add_repeatable("--only", pass_on("--only"),
                      "A kind of checks: runs, episodes, snapshots, draws, constants, scripts, "
                      "leaks or speed (repeatable); default: all")
      .type_name("KIND");
  command.footer("Exit code: 0 nothing is wrong, 1 something is, 2 usage error.");
  command.on_run([options, task_options] { run(*options, *task_options); });
}

}  // namespace engram::apps
