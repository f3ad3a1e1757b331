#include "apps/run_flags.h"

#include <algorithm>
#include <initializer_list>
#include <string>

#include "apps/options.h"
#include "protocol/eval/run/settings.h"

namespace engram::apps {
namespace {

// Each option as its type has it.

void add(const Command& command, const std::string& flag, std::uint64_t& seed,
         const std::string& help) {
  add_seed(command, seed, help, flag).type_name("S");
}

// A latency, in steps or milliseconds.
void add(const Command& command, const std::string& flag, int& steps, const std::string& help) {
  const auto take = [&steps, flag](const std::string& text) { steps = parse_latency(flag, text); };
  command.add_option(flag, take, help).type_name("STEPS|MS").default_str(std::to_string(steps));
}

void add(const Command& command, const std::string& flag, int low, int high, int& value,
         const std::string& help) {
  add_int(command, flag, value, low, high, help);
}

}  // namespace

void add_run_flags(const Command& command, std::string_view name, RunOptions& run) {
  const auto in = [name](std::initializer_list<std::string_view> commands) {
    return std::find(commands.begin(), commands.end(), name) != commands.end();
  };
  // begin generated: flags (tools/surface, from api/surface.toml)
  if (in({"eval", "record", "probe"})) {
    add(command, "--policy-seed", run.policy_seed,
        "Of the policy's own random numbers: random and blind draw others, external policies get "
        "it in each request");
  }
  if (in({"eval"})) {
    add(command, "--repeat", 1, kMaxRepeat, run.repeat,
        "Rounds of the same episodes; round i has policy seed + i");
  }
  if (in({"eval", "record", "probe"})) {
    add(command, "--latency", run.latency,
        "Control steps (3), or milliseconds (120ms; a step has 50), from a question to its answer: "
        "the world goes on with the last action meanwhile");
  }
  // end generated
}

}  // namespace engram::apps
