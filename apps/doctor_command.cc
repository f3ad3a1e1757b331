#include "apps/doctor_command.h"

#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include <fstream>
#include <memory>
#include <thread>

#include "api/media.h"
#include "apps/options.h"
#include "apps/output.h"
#include "core/batch/queries.h"
#include "protocol/io/json.h"

namespace engram::apps {
namespace {

constexpr const char* kMeasuredTask = "RememberColor9-VLA-v0";

std::string compiled_mujoco() {
  constexpr int kBase = mjVERSION_HEADER < 1'000'000 ? 10 : 1000;  // 222: 2.2.2; 3017000: 3.17.0
  return fmt::format("{}.{}.{}", mjVERSION_HEADER / kBase / kBase, mjVERSION_HEADER / kBase % kBase,
                     mjVERSION_HEADER % kBase);
}

std::string compiler() {
#if defined(__clang__)
  return fmt::format("clang {}.{}.{}", __clang_major__, __clang_minor__, __clang_patchlevel__);
#else
  return fmt::format("gcc {}.{}.{}", __GNUC__, __GNUC_MINOR__, __GNUC_PATCHLEVEL__);
#endif
}

const char* build_kind() {
#ifdef NDEBUG
  return "optimised, without assertions";
#else
  return "with assertions";
#endif
}

// Instruction sets of this machine that matter for speed, the plain one left out.
JsonList instruction_sets() {
  JsonList sets;
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("sse4.2")) sets.emplace_back("sse4.2");
  if (__builtin_cpu_supports("avx")) sets.emplace_back("avx");
  if (__builtin_cpu_supports("avx2")) sets.emplace_back("avx2");
  if (__builtin_cpu_supports("fma")) sets.emplace_back("fma");
  if (__builtin_cpu_supports("avx512f")) sets.emplace_back("avx512f");
#endif
  return sets;
}

std::int64_t page_size() { return ::sysconf(_SC_PAGESIZE); }

// Memory that this process has in use, in bytes; 0 if the system does not say.
std::int64_t resident_bytes() {
  ::malloc_trim(0);  // what is free but kept for later does not count
  std::ifstream statm("/proc/self/statm");
  std::int64_t total = 0;
  std::int64_t resident = 0;
  statm >> total >> resident;
  return resident * page_size();
}

// A batch whose memory is all in use: it has been reset and stepped.
std::unique_ptr<Batch> touched_batch(int num_envs) {
  auto batch = make(kMeasuredTask, batch_options(num_envs, 1));
  batch->reset();
  const std::vector<float> actions(
      static_cast<std::size_t>(num_envs) * static_cast<std::size_t>(batch->action_dim()), 0.0F);
  batch->step(actions);
  return batch;
}

// Memory of one more environment in a batch. Two batches are compared, so that shared parts cancel
// out.
double measured_bytes_per_env() {
  constexpr int kSmall = 256;
  constexpr int kLarge = 8192;
  touched_batch(1).reset();  // growth that happens once per process
  const std::int64_t before = resident_bytes();
  const auto small = touched_batch(kSmall);
  const std::int64_t between = resident_bytes();
  const auto large = touched_batch(kLarge);
  const std::int64_t after = resident_bytes();
  return static_cast<double>((after - between) - (between - before)) / (kLarge - kSmall);
}

// "hardware", "software", or why there is none.
std::string describe(const EglInfo& egl) {
  if (!egl.available) return egl.problem;
  return fmt::format("{} on {}", egl.software ? "software" : "hardware", egl.platform);
}

Json examine() {
  const EglInfo egl = query_egl();
  const auto batch = make(kMeasuredTask, batch_options(kMaxThreads, 0));
  return JsonTable{{"version", version()},
                   {"mujoco_compiled", compiled_mujoco()},
                   {"mujoco_runtime", mj_versionString()},
                   {"compiler", compiler()},
                   {"build", build_kind()},
                   {"instruction_sets", instruction_sets()},
                   {"cores", std::thread::hardware_concurrency()},
                   {"threads", batch->options().threads},
                   {"memory_bytes", ::sysconf(_SC_PHYS_PAGES) * page_size()},
                   {"memory_task", kMeasuredTask},
                   {"bytes_per_env", Queries(*batch).bytes_per_env()},
                   {"resident_bytes_per_env", measured_bytes_per_env()},
                   {"egl", describe(egl)},
                   {"egl_available", egl.available},
                   {"egl_vendor", egl.vendor},
                   {"egl_renderer", egl.renderer}};
}

std::string facts_text(const Json& facts) {
  std::vector<std::string> sets;
  for (const Json& set : list(part(facts, "instruction_sets"))) sets.push_back(text(set));
  const auto fact = [&facts](const char* key) { return text(part(facts, key)); };
  const auto count = [&facts](const char* key) { return with_thousands(number(part(facts, key))); };
  return fmt::format(
      "engram            {}, {}, {}\n"
      "MuJoCo            {} (compiled against {})\n"
      "instruction sets  {}\n"
      "cores             {}, {} threads by default\n"
      "memory            {} bytes\n"
      "per environment   {} bytes of columns, {} bytes resident ({})\n"
      "EGL               {}; {}\n",
      fact("version"), fact("compiler"), fact("build"), fact("mujoco_runtime"),
      fact("mujoco_compiled"), fmt::join(sets, " "), count("cores"), count("threads"),
      count("memory_bytes"), count("bytes_per_env"), count("resident_bytes_per_env"),
      fact("memory_task"), fact("egl"), fact("egl_renderer"));
}

void run(bool json) {
  const Json facts = examine();
  print(json ? to_text(facts) : facts_text(facts));
}

}  // namespace

void add_doctor_command(const Command& program) {
  const auto json = std::make_shared<bool>(false);
  const Command command =
      program.add_command("doctor", "Versions, instruction sets, threads, memory per environment");
  add_json(command, *json);
  command.on_run([json] { run(*json); });
}

}  // namespace engram::apps
