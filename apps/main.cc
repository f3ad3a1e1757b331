// The `engram` command: subcommands, each in its own files, and how failures are reported.
#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "apps/bench_command.h"
#include "apps/check_command.h"
#include "apps/collect_command.h"
#include "apps/command_line.h"
#include "apps/compare_command.h"
#include "apps/doctor_command.h"
#include "apps/eval_command.h"
#include "apps/info_command.h"
#include "apps/list_command.h"
#include "apps/merge_command.h"
#include "apps/output.h"
#include "apps/play_command.h"
#include "apps/probe_command.h"
#include "apps/record_command.h"
#include "apps/report_command.h"
#include "apps/reproduce_command.h"
#include "apps/rollout_command.h"
#include "apps/serve_command.h"
#include "apps/soak_command.h"
#include "apps/task_files.h"
#include "apps/verify_command.h"
#include "protocol/make/environment_files.h"
#include "protocol/make/make.h"
#include "protocol/make/task_library.h"
#include "protocol/make/variants.h"

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

// Options that register tasks. Returns them as given, for processes that the command starts. Those
// of tasks are taken first, wherever they stand: variants may be of such tasks.
std::shared_ptr<const std::vector<std::string>> add_task_options(const Command& program) {
  const auto given = std::make_shared<std::vector<std::string>>();
  const auto add = [&](const std::string& name, void (*load)(const std::filesystem::path&),
                       const std::string& help) {
    const auto take = [given, name, load](const std::string& file) {
      load(file);
      given->push_back(name + "=" + file);
    };
    program.add_repeatable(name, take, help).type_name("FILE");
  };
  add("--tasks", load_task_file,
      "Loads the tasks of a Python file (docs/custom_tasks.md; FILE.py:ID for an id does the same) "
      "or "
      "of a library (docs/cpp_tasks.md), as the environment variable ENGRAM_TASKS does "
      "(repeatable)");
  add("--variants", load_variants,
      "Registers the variants of a file of ids and constants (docs/variants.md), as "
      "the environment variable ENGRAM_VARIANTS does (repeatable)");
  return given;
}

int run(int argc, char** argv) {
  CommandLine line("engram", "Batched simulator of tabletop memory tasks");
  line.require_command();
  line.set_version(std::string("engram ") + version());
  const Command program = line.program();
  const auto task_options = add_task_options(program);
  program.share_options();
  program.footer("Exit code: 0 success, 1 failure, 2 usage error.");
  add_list_command(program);
  add_info_command(program);
  add_rollout_command(program);
  add_eval_command(program);
  add_probe_command(program);
  add_merge_command(program);
  add_compare_command(program);
  add_reproduce_command(program);
  add_report_command(program);
  add_collect_command(program, task_options);
  add_record_command(program);
  add_play_command(program, task_options);
  add_check_command(program, task_options);
  add_serve_command(program, task_options);
  add_bench_command(program);
  add_soak_command(program);
  add_verify_command(program);
  add_doctor_command(program);
  load_environment_files(&load_task_file);
  std::vector<std::string> words = with_task_files({argv + 1, argv + argc});
  std::vector<char*> arguments = {argv[0]};
  for (std::string& word : words) arguments.push_back(word.data());
  const std::string asked_for = line.parse(static_cast<int>(arguments.size()), arguments.data());
  if (!asked_for.empty()) print(asked_for);
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
