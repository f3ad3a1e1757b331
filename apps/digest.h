// A digest of everything that a run shows an agent. Only the header is needed: no library.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "protocol/make.h"

namespace engram::apps {

// One running 64-bit hash per environment over its observation rows, rewards, terminations and
// truncations, combined in environment order at the end. Depends on what was computed alone, not on
// the threads and chunks that computed it.
class Digest {
 public:
  explicit Digest(int num_envs) : hashes_(static_cast<std::size_t>(num_envs)) {}

  // Takes in the outputs of the last reset or step.
  void update(const VectorEnv& env) {
    for (std::size_t i = 0; i < hashes_.size(); ++i) {
      add_row(env.observation(), i);
      add_row(env.rgb(), i);
      if (!env.rgb().empty()) add_row(env.proprio(), i);
      std::array<unsigned char, sizeof(float) + 2> rest{};
      std::memcpy(rest.data(), &env.reward()[i], sizeof(float));
      rest[sizeof(float)] = env.terminated()[i];
      rest[sizeof(float) + 1] = env.truncated()[i];
      hashes_[i] = XXH3_64bits_withSeed(rest.data(), rest.size(), hashes_[i]);
    }
  }

  std::uint64_t value() const {
    return XXH3_64bits(hashes_.data(), hashes_.size() * sizeof(std::uint64_t));
  }

 private:
  // One environment's row of an output; nothing where the output is empty.
  template <class T>
  void add_row(std::span<const T> rows, std::size_t env) {
    if (rows.empty()) return;
    const std::size_t width = rows.size() / hashes_.size();
    // The hash so far seeds that of the next piece.
    hashes_[env] = XXH3_64bits_withSeed(rows.data() + env * width, width * sizeof(T), hashes_[env]);
  }

  std::vector<std::uint64_t> hashes_;
};

}  // namespace engram::apps
