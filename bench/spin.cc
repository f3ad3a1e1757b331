#include "bench/spin.h"

#include <array>

#include "bench/interleave.h"

namespace engram::bench {

double spin(ThreadPool& pool, int turns) {
  constexpr int kItems = 64;
  std::array<double, kItems> sums{};
  const double spent = seconds([&] {
    pool.run(kItems, 1, [&sums, turns](int /*worker*/, int begin, int end) {
      for (int item = begin; item < end; ++item) {
        double x = item + 1.0;
        for (int turn = 0; turn < turns; ++turn) x = x * 1.0000001 + 1e-9;
        sums[static_cast<std::size_t>(item)] = x;
      }
    });
  });
  return kItems / spent;
}

}  // namespace engram::bench
