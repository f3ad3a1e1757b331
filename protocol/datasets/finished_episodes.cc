#include "protocol/datasets/finished_episodes.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

namespace engram {
namespace {

constexpr const char* kFolder = "waiting";

std::string file_name(int episode) { return std::to_string(episode) + ".npz"; }

// From the task's folder.
std::string path_of(int episode) { return std::string(kFolder) + "/" + file_name(episode); }

}  // namespace

std::map<int, Demonstration> FinishedEpisodes::known() const {
  std::map<int, Demonstration> known;
  const auto records = records_.find(task_);
  if (records == records_.end()) return known;
  for (const auto& [episode, record] : records->second) {
    ByteReader in(record);
    known.emplace(episode, Demonstration::unpack(in));
  }
  return known;
}

bool FinishedEpisodes::has_file(int episode) const {
  return ::faccessat(folder_.descriptor(), path_of(episode).c_str(), F_OK, 0) == 0;
}

void FinishedEpisodes::add_record(int episode, const Demonstration& demonstration) {
  Demonstration alone = demonstration;
  alone.file.clear();
  ByteWriter record;
  alone.pack(record);
  journal_->add(task_, episode, record.bytes());
}

// The record comes last: an episode that has one is complete.
void FinishedEpisodes::add(int episode, const Demonstration& demonstration) {
  if (!demonstration.file.empty()) {
    folder_.subfolder(kFolder).write_file(file_name(episode),
                                          std::span<const std::byte>(demonstration.file));
  }
  add_record(episode, demonstration);
}

void FinishedEpisodes::add_from(const FinishedEpisodes& other, int episode,
                                const Demonstration& demonstration) {
  const std::string path = path_of(episode);
  if (other.has_file(episode)) {
    const OpenFolder own = folder_.subfolder(kFolder);
    const bool linked = ::linkat(other.folder_.descriptor(), path.c_str(), own.descriptor(),
                                 file_name(episode).c_str(), 0) == 0 ||
                        errno == EEXIST;
    // On another file system, or one without links.
    if (!linked) own.write_file(file_name(episode), other.folder_.read_file(path).value_or(""));
  }
  add_record(episode, demonstration);
}

void FinishedEpisodes::move_file(int episode, const std::string& name) {
  if (::renameat(folder_.descriptor(), path_of(episode).c_str(), folder_.descriptor(),
                 name.c_str()) == 0) {
    return;
  }
  const int error = errno;
  throw Error(Error::kIo, "'" + (folder_.path() / name).string() +
                              "' cannot be written: " + std::strerror(error));
}

void FinishedEpisodes::clear() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_.path() / kFolder, ignored);
  journal_->remove();
}

}  // namespace engram
