// Snapshots: environments as bytes, bit-exactly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/batch/batch.h"

namespace engram {

// Saves and restores one environment of a batch, or all. A snapshot may be restored into any slot
// of any batch of the same task, control mode, rules and task options; the other options are those
// of that batch. All environments of several tasks fit a batch of the same tasks in the same order;
// one of them is saved as a batch of its task alone would save it.
class Snapshotter {
 public:
  // The batch outlives this object.
  explicit Snapshotter(Batch& batch) : batch_(batch) {}

  std::vector<std::byte> save(int env) const;
  std::vector<std::byte> save() const;
  // Number of bytes that save returns; always the same. Throws Error where save would.
  std::size_t save_size(int env) const;
  std::size_t save_size() const;
  // Throw Error, changing nothing, if the bytes are damaged or of another task, version or number
  // of environments.
  void restore(int env, std::span<const std::byte> bytes) const;
  void restore(std::span<const std::byte> bytes) const;

 private:
  Batch& batch_;
};

}  // namespace engram
