// The objects observation in words, for language models.
#pragma once

#include <span>
#include <string>

#include "core/batch/batch.h"

namespace engram {

// Words for a row of the objects observation, which say nothing that the row does not: "hand at
// x 0.00 m, y 0.00 m, z 0.20 m, 100 % open; red cube at x 0.12 m, y -0.05 m, z 0.02 m; 2 objects
// hidden".
class ObjectText {
 public:
  // The batch observes objects.
  explicit ObjectText(const Batch& batch);

  std::string describe(std::span<const float> row) const;

 private:
  std::size_t tokens_ = 0;  // offset of the first token
};

}  // namespace engram
