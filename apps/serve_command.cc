#include "apps/serve_command.h"

#include "apps/python_module.h"
#include "core/base/error.h"

namespace engram::apps {

void add_serve_command(const Command& program,
                       const std::shared_ptr<const std::vector<std::string>>& task_options) {
  // Checked by Python.
  const auto arguments = std::make_shared<std::vector<std::string>>();
  const Command command = program.add_command(
      "serve", "Serves a policy to clients of policy servers (docs/policy_servers.md)");
  const auto pass_on = [arguments](const std::string& name) {
    return [arguments, name](const std::string& value) {
      if (value.empty()) throw Error(Error::kInvalidArgument, name + ": '' given, a text needed");
      arguments->push_back(name + "=" + value);
    };
  };
  const auto add = [&](const std::string& name, const std::string& type, const std::string& help) {
    return command.add_option(name, pass_on(name), help).type_name(type);
  };
  add("--policy", "NAME|FILE", "oracle|sweep|blind|random|zero, or a file that --loader loads")
      .required();
  add("--loader", "FILE.py:NAME",
      "Function that makes a policy of the file, such as "
      "python/learners/src/engram_learners/inference.py:PolicyRunner.load of agent.pt");
  add("--protocol", "openpi|gr00t|act", "Default: openpi");
  add("--host", "ADDRESS", "Address to listen at; default: 127.0.0.1, this machine alone");
  add("--port", "INT", "Port to listen at; default: the protocol's usual one; 0: a free one");
  add("--chunk", "K", "Actions of an answer; default: 1");
  add("--server-keys", "NAME|FILE.json", "Names of what clients send, as of eval");
  add("--rules", "reference|original", "Rules of the client's tasks; default: reference");
  add("--physics", "engram|mujoco", "Of the client's batches; default: engram");
  add("--control-mode", "MODE", "As of the client; default: the task's own");
  command.add_flag(
      "--joint-proprio", [arguments] { arguments->emplace_back("--joint-proprio"); },
      "As of the client");
  for (const char* name : {"--set", "--option"}) {
    command.add_repeatable(name, pass_on(name), "As of the client's tasks (repeatable)")
        .type_name("NAME=VALUE");
  }
  command.footer(
      "engram's own policies need the client's --tell-episodes: they play its episode beside it. "
      "They are for tests of clients.");
  command.on_run([arguments, task_options] {
    std::vector<std::string> words = python_words("engram.servers", "serve");
    words.emplace_back("serve");
    words.insert(words.end(), task_options->begin(), task_options->end());
    words.insert(words.end(), arguments->begin(), arguments->end());
    become(std::move(words), "serve");
  });
}

}  // namespace engram::apps
