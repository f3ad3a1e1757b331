// Check that the same seeds give the same bits for any batch size, threads and instruction set.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "protocol/make/make.h"
#include "render/cpu/cpu_renderer.h"

namespace engram::bench {

// Configuration of one run of the same episode segments.
struct RunConfig {
  int threads = 1;
  int chunk = 0;          // 0: chosen
  int num_envs = 64;      // environments stepped together
  bool shuffled = false;  // the order in which segments fill the slots
  InstructionSet instruction_set = InstructionSet::kAuto;  // kAuto too where the machine lacks it
};

// The configuration with which all others are compared.
inline constexpr RunConfig kReferenceConfig = {};

// The other configurations. They hold every pair of a number of threads (1, 2,
// 3, 4, 8), a chunk (0, 1, 5), a batch size (64, 7, 1) and an order, except that a batch of one has
// one thread. Instruction sets take turns.
std::span<const RunConfig> run_configs();

// Episode segments of each run: half from a reset, half from snapshots along 16 whole
// episodes, up to and past their ends. State checks also compare those episodes as wholes.
inline constexpr int kSegments = 128;

// Makes a batch that runs on that instruction set.
std::unique_ptr<Batch> make_on(InstructionSet set, const std::string& id,
                               const MakeOptions& options);

struct IdentityOptions {
  ObsMode obs_mode = ObsMode::kState;
  int steps = 15;          // control steps of each segment
  std::uint64_t seed = 0;  // the first of 64
  // Makes the batches.
  std::function<std::unique_ptr<Batch>(InstructionSet set, const std::string& id,
                                       const MakeOptions& options)>
      make_batch = make_on;
  std::function<void(double fraction)> progress = [](double) {};  // called between runs
};

struct IdentityResult {
  int runs = 0;                   // beside the reference
  std::int64_t env_steps = 0;     // compared with those of the reference
  std::int64_t episodes = 0;      // ended in them
  std::int64_t different = 0;     // segments with a difference, over all runs
  std::uint64_t fingerprint = 0;  // hash of the outputs of the reference's segments
};

// Runs the task with all configurations. In every reset and step the outputs, images and memory of
// every environment are compared with the reference's, by 64-bit hashes. Throws Error if the id or
// an option is not allowed, or the machine lacks what is needed.
IdentityResult check_identity(const std::string& id, const IdentityOptions& options);

}  // namespace engram::bench
