// Interface of policies in the episodes of an evaluation's batch: external ones and engram's own.
#pragma once

#include <cstdint>
#include <span>

#include "protocol/eval/policies/episode_digests.h"

namespace engram {

// The names of an episode for people and for policies.
struct EpisodeLabel {
  int episode = -1;         // of the evaluation, from 0; -1: none
  std::int32_t number = 0;  // for the policy
  std::uint64_t seed = 0;
};

class EpisodeActor {
 public:
  virtual ~EpisodeActor() = default;

  // An episode begins in the environment `env`.
  virtual void start(int env, const EpisodeLabel& label) = 0;
  // Replaces the scene without telling the policy: it remembers what it did; its actions on the
  // way are dropped.
  virtual void replace_scene(int env, const EpisodeLabel& label) = 0;
  virtual void finish(int env) = 0;
  // Actions of all environments; zeros for those without an episode. commanded: 0 for those that
  // have no action yet, 1 for the others.
  virtual void act(std::span<float> actions, std::span<std::uint8_t> commanded) = 0;

  // Digests of the episode under way, or of the last one.
  virtual const EpisodeDigests& digests(int env) const = 0;
  // Actions of the longest chunk so far.
  virtual int longest_chunk() const { return 1; }
};

}  // namespace engram
