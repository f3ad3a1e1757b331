// What a journal says of its run: on which settings its results depend, and which share it is.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "protocol/io/json.h"
#include "protocol/parallel/shares.h"

namespace engram {

// What is played of a run, and the words that it began with.
struct EpisodePart {
  std::optional<Shard> shard = {};
  std::vector<std::string> command = {};
};

struct RunHeader {
  struct Task {
    std::string name;  // of the journal's records
    TaskLoad load;
  };

  std::string kind;                  // the subcommand
  std::optional<Shard> shard;        // none: all of the run
  std::vector<std::string> command;  // the words that began it, for messages
  Json run;                          // the settings
  std::vector<Task> tasks;           // in the order of shares

  JsonTable document() const;
  // Throws Error (kIo) if the document is none.
  static RunHeader of(const Json& document, const std::filesystem::path& file);

  std::vector<TaskLoad> loads() const;
  // The command of another shard of the run, as a line for a shell.
  std::string command_of(const Shard& other) const;
  // The command of a run of all tasks, into a folder.
  std::string command_of_whole(const std::string& out) const;
};

// Words that a shell reads as they are.
std::string shell_line(const std::vector<std::string>& words);

}  // namespace engram
