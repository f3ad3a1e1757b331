// Trials: episodes whose course from cue to question a probe of memory decides (docs/probe.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/task/episode.h"

namespace engram {

// An episode by what it is drawn from.
struct EpisodeDraw {
  std::uint64_t seed = 0;
  std::vector<Pin> pins = {};
};

// The question is the moment from which on the policy acts.
struct Trial {
  EpisodeDraw draw = {};
  // Control steps before the question, in which the policy is asked and the robot rests, but for
  // tasks that show their cue to a robot at work: the oracle leads to it. 0: the policy acts from
  // the first step on. Below 0: the cue never shows, and nothing is played.
  int question = 0;
  bool wiped = false;  // at the question, the request says that a new episode begins
  // A snapshot of another episode at the question, which takes this one's place; or null.
  std::shared_ptr<const std::vector<std::byte>> scene = {};
  // Episodes that the policy plays at the question, from their beginning to their end, before it
  // goes on with this one. It is not informed.
  std::vector<EpisodeDraw> others = {};
  bool until_answer = false;  // nothing after the first answer counts
  int twin = -1;  // the trial of the same group whose present at the question is to be the same
};

struct TrialResult {
  std::uint8_t played = 0;     // the question came
  std::uint8_t exchanged = 0;  // another scene took its place at the question
  std::uint8_t success = 0;
  std::uint8_t answered = 0;
  std::uint8_t correct = 0;
  std::uint8_t compared = 0;        // its present with the twin's
  std::uint8_t same_present = 0;    // to the bit
  std::uint8_t other_answered = 0;  // in the last one of the others
  std::int32_t answer = 0;
  std::int32_t other_answer = 0;
};

// Trials of one episode number that belong together.
using TrialGroup = std::vector<Trial>;

}  // namespace engram
