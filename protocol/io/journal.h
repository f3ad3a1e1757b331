// The journal of a run: each finished episode, appended to one file as soon as it is known.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "protocol/io/bytes.h"
#include "protocol/io/files.h"
#include "protocol/io/json.h"

namespace engram {

inline constexpr const char* kJournalFile = "episodes.journal";

// Results by task and episode.
using JournalRecords = std::map<std::string, std::map<int, Bytes>>;

// The content of a journal. Records behind damage, such as the torn end that a killed process has
// left, are not there.
struct JournalContent {
  Json header;
  JournalRecords records;
  std::size_t size = 0;     // bytes of the whole records
  std::uint64_t chain = 0;  // hash of the last one
};

// The journal in a folder, unchanged; nothing if there is none. Throws Error (kIo) if the file is
// not a journal, or its beginning is damaged.
std::optional<JournalContent> read_journal(const OpenFolder& folder);

class Journal {
 public:
  // Goes on with the folder's journal, without its damaged end, or begins one, also in place of one
  // without records. The folder outlives this object and is locked. header: what the run is. Throws
  // Error: kInvalidArgument if the journal is of another run, with the key that differs; kIo.
  Journal(const OpenFolder& folder, const JsonTable& header);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  const JournalRecords& records() const { return records_; }
  std::size_t size() const;  // records
  // Appends a result. Throws Error (kIo); the file is then as before.
  void add(std::string_view task, int episode, const Bytes& result);
  void add(const JournalRecords& records);
  // Removes the file: everything is in files of its own.
  void remove();

 private:
  void open(std::size_t size);

  const OpenFolder& folder_;
  JournalRecords records_;
  std::uint64_t chain_ = 0;
  int descriptor_ = -1;
  std::int64_t bytes_ = 0;   // of the file
  std::int64_t synced_ = 0;  // milliseconds of a steady clock
};

// Throws Error (kInvalidArgument) unless both headers describe one run, but for the keys that
// are left out; names the first key that differs, at any depth. there, here: what has them.
void require_same_run(const Json& before, const std::string& there, const Json& now,
                      const std::string& here);

}  // namespace engram
