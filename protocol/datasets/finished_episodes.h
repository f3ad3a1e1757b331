// Finished episodes of a task that are no data files yet: a record of each in a journal, and the
// files of those to keep.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "protocol/datasets/recorder.h"
#include "protocol/io/journal.h"

namespace engram {

class FinishedEpisodes {
 public:
  // folder: of the task, which outlives this object, as the journal does.
  FinishedEpisodes(const OpenFolder& folder, Journal& journal, std::string_view task)
      : folder_(folder), records_(journal.records()), journal_(&journal), task_(task) {}
  // To be read only.
  FinishedEpisodes(const OpenFolder& folder, const JournalRecords& records, std::string_view task)
      : folder_(folder), records_(records), task_(task) {}

  // All of them, without the contents of their files.
  std::map<int, Demonstration> known() const;
  // True if the episode's file is there.
  bool has_file(int episode) const;

  // Adds an episode, with its file if it has one. Throws Error (kIo).
  void add(int episode, const Demonstration& demonstration);
  // Adds one of another folder, whose file stays.
  void add_from(const FinishedEpisodes& other, int episode, const Demonstration& demonstration);
  // Makes the episode's file one of the task's folder, under that name. Throws Error (kIo).
  void move_file(int episode, const std::string& name);
  // Removes everything.
  void clear();

 private:
  void add_record(int episode, const Demonstration& demonstration);

  const OpenFolder& folder_;
  const JournalRecords& records_;
  Journal* journal_ = nullptr;
  std::string task_;
};

}  // namespace engram
