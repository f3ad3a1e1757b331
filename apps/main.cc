// The `engram` command: subcommands, each in its own files, and how failures are reported.
#include <CLI/CLI.hpp>
#include <exception>
#include <new>
#include <string>
#include <vector>

#include "apps/bench_command.h"
#include "apps/collect_command.h"
#include "apps/doctor_command.h"
#include "apps/eval_command.h"
#include "apps/info_command.h"
#include "apps/list_command.h"
#include "apps/output.h"
#include "apps/record_command.h"
#include "apps/rollout_command.h"
#include "apps/soak_command.h"
#include "apps/verify_command.h"
#include "protocol/batch/make.h"

namespace engram::apps {
namespace {

constexpr int kSuccess = 0;
constexpr int kFailure = 1;
constexpr int kUsageError = 2;

// Usage errors are those that the user can avoid by asking for something else.
int exit_code(const Error& error) {
  const bool usage = error.kind() == Error::kInvalidArgument || error.kind() == Error::kUnknownId;
  return usage ? kUsageError : kFailure;
}

// The parser's message, or a clearer one of ours.
std::string explain(const CLI::App& app, const CLI::ParseError& error) {
  std::string what = error.what();
  std::string program = "engram";
  for (const CLI::App* command : app.get_subcommands()) program += " " + command->get_name();
  const std::vector<std::string> unexpected = app.remaining(true);
  if (!unexpected.empty()) {
    what = app.get_subcommands().empty() ? "no command" : "unexpected";
    for (const std::string& argument : unexpected) what += " '" + argument + "'";
  } else if (app.get_subcommands().empty()) {
    what = "no command given";
  }
  return what + "; `" + program + " --help` shows what is allowed";
}

int run(int argc, char** argv) {
  CLI::App app("Batched MuJoCo simulator of tabletop memory tasks", "engram");
  app.require_subcommand(1);
  app.set_version_flag("--version", std::string("engram ") + version());
  app.footer("Exit code: 0 success, 1 failure, 2 usage error.");
  add_list_command(app);
  add_info_command(app);
  add_rollout_command(app);
  add_eval_command(app);
  add_collect_command(app);
  add_record_command(app);
  add_bench_command(app);
  add_soak_command(app);
  add_verify_command(app);
  add_doctor_command(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    print(app.help());
  } catch (const CLI::CallForVersion& version_text) {
    print(std::string(version_text.what()) + "\n");
  } catch (const CLI::ParseError& error) {
    print_error(explain(app, error));
    return kUsageError;
  }
  return kSuccess;
}

int run_safely(int argc, char** argv) noexcept {
  try {
    return run(argc, argv);
  } catch (const Error& error) {
    print_error(error.what());
    return exit_code(error);
  } catch (const std::bad_alloc&) {
    print_error("out of memory");
  } catch (const std::exception& error) {
    print_error(error.what());
  } catch (...) {
    print_error("unknown failure");
  }
  return kFailure;
}

}  // namespace
}  // namespace engram::apps

int main(int argc, char** argv) {
  engram::apps::guard_standard_streams();
  return engram::apps::run_safely(argc, argv);
}
