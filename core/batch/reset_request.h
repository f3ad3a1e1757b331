// Arguments of a reset.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/index.h"
#include "core/task/episode.h"

namespace engram {

// Environments to reset, and their new seeds, pins and ranges. Empty spans: all environments; seeds
// and pins as before.
struct ResetRequest {
  std::span<const std::uint8_t> mask;      // num_envs values, non-zero: reset
  std::span<const std::uint64_t> seeds;    // num_envs values; those of masked-out ones are ignored
  const std::vector<Pin>* pins = nullptr;  // replaces the pins of the environments that are reset
  // Replaces their narrower ranges: range constants, [least, greatest] within those of the batch.
  const ConstantTable* constants = nullptr;

  bool selects(int env) const { return mask.empty() || mask[at(env)] != 0; }
};

// A request whose arguments fit the task.
struct CheckedReset {
  ResetRequest request;
  const std::vector<Pin>* pins = nullptr;  // new ones
  std::vector<NarrowedRange> ranges = {};  // new ones, where the request has constants
};

}  // namespace engram
