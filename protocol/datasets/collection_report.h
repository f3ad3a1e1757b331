// The report of `engram collect`: one HTML file.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "protocol/datasets/demonstration_folder.h"

namespace engram {

// Timing of the run that has just ended.
struct CollectionTiming {
  double seconds = 0;
  int episodes = 0;             // that it added
  std::uint64_t env_steps = 0;  // that it played, failed episodes included
};

// The share of attempts that were kept.
double keep_rate(const DemonstrationFolder& folder);

// The document: rates, lengths, sizes, timing, and images of every task's first episode.
std::string collection_report(std::span<const std::unique_ptr<DemonstrationFolder>> folders,
                              const CollectionTiming& timing);

}  // namespace engram
