// Whether the same seeds give the same bits, however a batch is run.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "protocol/batch/make.h"
#include "render/cpu_renderer.h"

namespace engram::bench {

// One way of running the same stretches of episodes.
struct Play {
  int threads = 1;
  int chunk = 0;          // 0: chosen
  int num_envs = 64;      // environments stepped together
  bool shuffled = false;  // the order in which stretches fill the slots
  InstructionSet instruction_set = InstructionSet::kAuto;  // kAuto too where the machine has it not
};

// What all plays are compared to.
inline constexpr Play kReferencePlay = {};

// The plays that are compared to the reference. They hold every pair of a number of threads (1, 2,
// 3, 4, 8), a chunk (0, 1, 5), a batch size (64, 7, 1) and an order, except that a batch of one has
// one thread. Instruction sets take turns.
std::span<const Play> plays();

// Stretches of episodes of each play: half from a reset, half from snapshots along 16 whole
// episodes, up to and past their ends. State checks also compare those episodes as wholes.
inline constexpr int kStretches = 128;

// Makes a batch that runs on that instruction set.
std::unique_ptr<Batch> make_on(InstructionSet set, const std::string& id,
                               const MakeOptions& options);

struct IdentityOptions {
  ObsMode obs_mode = ObsMode::kState;
  int steps = 15;          // control steps of each stretch
  std::uint64_t seed = 0;  // the first of 64
  // Makes the batches.
  std::function<std::unique_ptr<Batch>(InstructionSet set, const std::string& id,
                                       const MakeOptions& options)>
      make_batch = make_on;
  std::function<void(double fraction)> progress = [](double) {};  // called between plays
};

struct IdentityResult {
  int plays = 0;                  // beside the reference
  std::int64_t env_steps = 0;     // compared with those of the reference
  std::int64_t episodes = 0;      // ended in them
  std::int64_t different = 0;     // stretches with a difference, over all plays
  std::uint64_t fingerprint = 0;  // hash of what the reference's stretches show
};

// Plays the task in all ways. In every reset and step the outputs, images and memory of every
// environment are compared with the reference's, by 64-bit hashes. Throws Error if the id or an
// option is not allowed, or the machine lacks what is needed.
IdentityResult check_identity(const std::string& id, const IdentityOptions& options);

}  // namespace engram::bench
