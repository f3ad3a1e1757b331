// Digests of what a policy saw in an episode and of what it answered. With those of two runs one
// can tell another environment from another policy (docs/evaluation.md).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "core/batch/batch.h"

namespace engram {

// One environment as its policy sees it.
struct PolicyView {
  std::int32_t step = 0;  // control steps so far
  std::string instruction;
  std::span<const float> proprio;
  std::span<const std::uint8_t> rgb;  // empty without images
  std::span<const float> state;       // empty with images
};

PolicyView view_of(const Batch& batch, int env);

// Hashes of all questions and of all answers, and of the first ones.
struct EpisodeDigests {
  std::uint64_t observations = 0;
  std::uint64_t answers = 0;
  std::uint64_t first_observation = 0;
  std::uint64_t first_answer = 0;

  // A question, and then its answer: actions, one after the other.
  void add_question(const PolicyView& view);
  void add_answer(std::int32_t step, std::span<const float> actions, int action_dim);
};

// The digests by their keys in results.
inline constexpr std::pair<const char*, std::uint64_t EpisodeDigests::*> kDigestKeys[] = {
    {"observations", &EpisodeDigests::observations},
    {"answers", &EpisodeDigests::answers},
    {"first_observations", &EpisodeDigests::first_observation},
    {"first_answers", &EpisodeDigests::first_answer}};

}  // namespace engram
