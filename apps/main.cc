// The `engram` command: subcommands, each in its own files, and how failures are reported.
#include <exception>
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
#include "apps/output.h"
#include "apps/play_command.h"
#include "apps/record_command.h"
#include "apps/report_command.h"
#include "apps/rollout_command.h"
#include "apps/serve_command.h"
#include "apps/soak_command.h"
#include "apps/verify_command.h"
#include "protocol/batch/make.h"
#include "protocol/batch/variants.h"

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

int run(int argc, char** argv) {
  CommandLine line("engram", "Batched simulator of tabletop memory tasks");
  line.require_command();
  line.set_version(std::string("engram ") + version());
  const Command program = line.program();
  const auto variants = std::make_shared<std::vector<std::string>>();
  program
      .add_option(
          "--variants",
          [variants](const std::string& file) {
            load_variants(file);
            variants->push_back(file);
          },
          "Registers the variants of a file of ids and constants (docs/variants.md), as "
          "the environment variable ENGRAM_VARIANTS does")
      .type_name("FILE");
  program.share_options();
  program.footer("Exit code: 0 success, 1 failure, 2 usage error.");
  add_list_command(program);
  add_info_command(program);
  add_rollout_command(program);
  add_eval_command(program);
  add_compare_command(program);
  add_report_command(program);
  add_collect_command(program, variants);
  add_record_command(program);
  add_play_command(program, variants);
  add_check_command(program, variants);
  add_serve_command(program, variants);
  add_bench_command(program);
  add_soak_command(program);
  add_verify_command(program);
  add_doctor_command(program);
  load_environment_variants();
  const std::string asked_for = line.parse(argc, argv);
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
