// Estimate of what a collection takes, from the first attempts of its tasks.
#pragma once

#include <string>
#include <vector>

#include "apps/interruption.h"
#include "protocol/datasets/collection.h"
#include "protocol/io/json.h"

namespace engram::apps {

struct CollectEstimate {
  struct Task {
    std::string id;
    double steps = 0;  // of all planned episodes
    double bytes = 0;  // of their files
    double thread_seconds = 0;
  };
  std::vector<Task> tasks;
  int episodes = 0;  // per task
  int threads = 1;   // of the collection

  double bytes() const;
  double seconds() const;  // with all threads busy to the end
  Json document() const;
  std::string text() const;
};

// Plays the first attempts of each task, until an episode is kept, in a temporary folder that is
// gone afterwards. Throws Error as `collect` does, and where no attempt succeeds.
CollectEstimate estimate_collection(std::span<const RegistryEntry* const> tasks,
                                    const CollectionOptions& options,
                                    const Interruption& interruption);

}  // namespace engram::apps
