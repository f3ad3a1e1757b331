// Options of commands that play many episodes: which share of them, with which processes, how long.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/command_line.h"
#include "protocol/parallel/ranks.h"
#include "protocol/parallel/shares.h"

namespace engram::apps {

struct RunControl {
  std::optional<Shard> shard;
  MpiMode mpi = MpiMode::kAuto;
  unsigned time_limit = 0;  // seconds; 0: none
};

void add_run_control(const Command& command, RunControl& control);

// "90", "90s", "55m" or "2h", in seconds. Throws Error for anything else.
unsigned parse_time_limit(const std::string& text);

// Throws Error where a shard has no folder.
void require_folder(const RunControl& control, const std::string& out);

// Prints that a shard is finished, and how all of them become one result.
void print_shard(const Shard& shard, const std::filesystem::path& folder, std::size_t episodes,
                 bool json);

// The words of this program's command line.
std::vector<std::string> words_of_command();

}  // namespace engram::apps
