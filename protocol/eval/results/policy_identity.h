// What a policy tells of itself while it is evaluated, such as the checkpoint that a server has.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "protocol/eval/results/result_files.h"

namespace engram {

class PolicyIdentity {
 public:
  // folder: of the run. It keeps what was told beside the results, from an earlier process as well.
  explicit PolicyIdentity(std::optional<ResultFolder> folder);

  // Called by any thread with a JSON object, or null for nothing; the first object is kept. Throws
  // Error (kUnavailable) if it has another checkpoint than the one before.
  void take(const Json& told);
  // Null if nothing was told.
  Json document() const;

  // Read from the folder of a run; null if its policy told nothing.
  static Json in(const OpenFolder& folder);

 private:
  std::optional<ResultFolder> folder_;
  mutable std::mutex mutex_;
  Json told_;
};

// The checkpoint of what a policy told; null if it told none.
Json checkpoint_of(const Json& told);
// True if both tell a checkpoint, and not the same one.
bool has_other_checkpoint(const Json& a, const Json& b);
// For messages.
std::string checkpoint_text(const Json& told);

}  // namespace engram
