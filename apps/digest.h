// A digest of all observations, rewards and ends of episodes of a run.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "bench/row_hash.h"
#include "protocol/make/make.h"

namespace engram::apps {

// One running 64-bit hash per environment over its observation rows, rewards, terminations and
// truncations, combined in environment order at the end. Does not depend on
// threads and chunks.
class Digest {
 public:
  explicit Digest(int num_envs) : hashes_(static_cast<std::size_t>(num_envs)) {}

  // Takes in the outputs of the last reset or step. env: a batch of that many environments.
  void update(const Batch& batch) {
    const std::size_t count = hashes_.size();
    for (std::size_t i = 0; i < count; ++i) {
      std::uint64_t& hash = hashes_[i];
      hash = bench::chain_row(hash, batch.outputs().observation, count, i);
      hash = bench::chain_row(hash, batch.images().rgb, count, i);
      if (!batch.images().rgb.empty())
        hash = bench::chain_row(hash, batch.outputs().proprio, count, i);
      std::array<unsigned char, sizeof(float) + 2> rest{};
      std::memcpy(rest.data(), &batch.outputs().reward[i], sizeof(float));
      rest[sizeof(float)] = batch.outputs().terminated[i];
      rest[sizeof(float) + 1] = batch.outputs().truncated[i];
      hash = bench::chain_row(hash, std::span<const unsigned char>(rest), 1, 0);
    }
  }

  std::uint64_t value() const { return bench::hash_of(hashes_); }
  const std::vector<std::uint64_t>& of_environments() const { return hashes_; }

 private:
  std::vector<std::uint64_t> hashes_;
};

}  // namespace engram::apps
