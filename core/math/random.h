// Counter-based random numbers: every draw is a pure function of seed, episode, purpose and
// position, so results depend on neither threads, batch size nor the order of environments.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <type_traits>

namespace engram {

// The numbers for one purpose in one episode, from Philox4x32-10 with the seed as key and
// {block, purpose, episode low, episode high} as counter. Different purposes are independent
// streams, so that fixing or adding a draw for one leaves all others as they were.
//
// Small, trivially copyable and without padding: a copy continues where the original stood, and a
// snapshot may store its bytes. Repeats after 2^32 words of 32 bits.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t episode, std::uint32_t purpose) noexcept
      : seed_(seed), episode_(episode), purpose_(purpose) {}

  // All 32 or 64 bits uniform. Consumes one or two words.
  std::uint32_t next_u32() noexcept {
    if (position_ % kBlock == 0) refill();
    return words_[position_++ % kBlock];
  }
  std::uint64_t next_u64() noexcept {
    const std::uint64_t low = next_u32();
    return std::uint64_t{next_u32()} << 32 | low;
  }

  // Uniform in [0, 1), a multiple of 2^-53. Consumes two words.
  double uniform() noexcept { return static_cast<double>(next_u64() >> 11) * 0x1p-53; }

  // Uniform in [lo, hi); lo itself if both are equal. Throws Error unless lo <= hi and both and
  // their difference are finite. Consumes two words.
  double uniform(double lo, double hi);

  // Uniform over lo, ..., hi, both included, without bias. Throws Error if lo > hi. Consumes one
  // word, rarely more.
  int integer(int lo, int hi);

  // Normal with mean 0 and standard deviation 1. Consumes four words.
  double normal() noexcept;

  // Fills `out` with a uniformly distributed permutation of 0, ..., out.size() - 1. Throws Error if
  // those do not fit into an int.
  void permutation(std::span<int> out);

 private:
  static constexpr std::uint32_t kBlock = 4;

  // Computes the block of words that position_ lies in.
  void refill() noexcept;

  std::uint64_t seed_;
  std::uint64_t episode_;
  std::array<std::uint32_t, kBlock> words_{};
  std::uint32_t purpose_;
  std::uint32_t position_ = 0;  // words drawn so far
};

static_assert(std::is_trivially_copyable_v<RandomStream>);
static_assert(std::has_unique_object_representations_v<RandomStream>);

}  // namespace engram
