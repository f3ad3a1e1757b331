#include "core/math/random.h"

#include <Random123/philox.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/math/real_functions.h"

namespace engram {
namespace {

constexpr std::uint32_t low_word(std::uint64_t x) { return static_cast<std::uint32_t>(x); }
constexpr std::uint32_t high_word(std::uint64_t x) { return static_cast<std::uint32_t>(x >> 32); }

}  // namespace

void RandomStream::refill() noexcept {
  const r123::Philox4x32::ctr_type counter = {
      {position_ / kBlock, purpose_, low_word(episode_), high_word(episode_)}};
  const r123::Philox4x32::key_type key = {{low_word(seed_), high_word(seed_)}};
  const auto block = r123::Philox4x32()(counter, key);
  words_ = {block[0], block[1], block[2], block[3]};
}

double RandomStream::uniform(double lo, double hi) {
  const double width = hi - lo;
  if (!(width >= 0) || !std::isfinite(width)) {
    throw Error(Error::kInvalidArgument, "uniform range [" + std::to_string(lo) + ", " +
                                             std::to_string(hi) +
                                             "): bounds must be finite and in order");
  }
  // Rounding may reach hi, which does not belong to the range.
  const double x = lo + width * uniform();
  return x < hi ? x : std::nextafter(hi, lo);
}

int RandomStream::integer(int lo, int hi) {
  if (lo > hi) {
    throw Error(Error::kInvalidArgument, "integer range [" + std::to_string(lo) + ", " +
                                             std::to_string(hi) + "]: bounds must be in order");
  }
  const std::uint64_t count = static_cast<std::uint64_t>(std::int64_t{hi} - lo) + 1;

  // Lemire's method: the high word of a product is the result. The 2^32 % count lowest products
  // would make some results more likely than others, so they are drawn again.
  std::uint64_t product = next_u32() * count;
  if (low_word(product) < count) {
    const std::uint64_t surplus = (std::uint64_t{1} << 32) % count;
    while (low_word(product) < surplus) product = next_u32() * count;
  }
  return static_cast<int>(lo + static_cast<std::int64_t>(product >> 32));
}

double RandomStream::normal() noexcept {
  // Box and Muller, using one of the pair, so that every call consumes the same number of words.
  // 1 - uniform() lies in (0, 1], where the logarithm is finite.
  const double radius = std::sqrt(-2 * real::log(1 - uniform()));
  return radius * real::cos(2 * std::numbers::pi * uniform());
}

void RandomStream::permutation(std::span<int> out) {
  if (out.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    throw Error(Error::kInvalidArgument,
                "permutation of " + std::to_string(out.size()) + " elements: at most 2147483647");
  }
  // Fisher and Yates: from the back, each place takes one of those not yet placed.
  std::iota(out.begin(), out.end(), 0);
  for (std::size_t i = out.size(); i > 1; --i) {
    std::swap(out[i - 1], out[static_cast<std::size_t>(integer(0, static_cast<int>(i) - 1))]);
  }
}

}  // namespace engram
