// The shards of one run, read from their folders.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "protocol/io/journal.h"
#include "protocol/parallel/run_header.h"

namespace engram {

// "shard-3-of-7", the folder of a shard in the one that is given for output.
std::string shard_folder(const Shard& shard);

// What is left to do of a shard, and the command for it, as a line for a shell.
struct MissingShard {
  Shard shard;
  int episodes = 0;
  std::string command;
};

class ShardSet {
 public:
  struct Part {
    std::filesystem::path folder;
    RunHeader header;
    JournalRecords records;
  };

  // Reads the folders of shards, and those in the folders of several. Throws Error:
  // kInvalidArgument if there are none, or they do not belong together; kIo.
  explicit ShardSet(std::span<const std::filesystem::path> folders);

  const RunHeader& header() const { return parts_.front().header; }
  const std::vector<Part>& parts() const { return parts_; }

  // Shards that are missing or not finished.
  std::vector<MissingShard> missing() const;

 private:
  void add(const std::filesystem::path& folder);

  std::vector<Part> parts_;
};

}  // namespace engram
