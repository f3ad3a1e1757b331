#include "protocol/parallel/shard_set.h"

#include <algorithm>

#include "core/base/error.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

// Episodes of the share that a shard has not finished.
int episodes_missing(const RunHeader& header, const std::vector<EpisodeRange>& share,
                     const JournalRecords* records) {
  int missing = 0;
  for (std::size_t i = 0; i < share.size(); ++i) {
    missing += share[i].size();
    if (records == nullptr) continue;
    const auto known = records->find(header.tasks[i].name);
    if (known == records->end()) continue;
    const auto begin = known->second.lower_bound(share[i].first);
    const auto end = known->second.lower_bound(share[i].end);
    missing -= static_cast<int>(std::distance(begin, end));
  }
  return missing;
}

}  // namespace

std::string shard_folder(const Shard& shard) {
  return "shard-" + std::to_string(shard.number) + "-of-" + std::to_string(shard.count);
}

ShardSet::ShardSet(std::span<const fs::path> folders) {
  for (const fs::path& folder : folders) {
    const std::size_t before = parts_.size();
    add(folder);
    if (parts_.size() > before) continue;
    std::vector<std::string> names = OpenFolder(folder).names();
    std::ranges::sort(names);
    for (const std::string& name : names) {
      if (name.starts_with("shard-") && fs::is_directory(folder / name)) add(folder / name);
    }
    if (parts_.size() > before) continue;
    throw Error(Error::kInvalidArgument, "'" + folder.string() +
                                             "' given, a folder of a shard (--shard I/N), or one "
                                             "that has them, needed");
  }
}

void ShardSet::add(const fs::path& folder) {
  const OpenFolder opened(folder);
  std::optional<JournalContent> journal = read_journal(opened);
  if (!journal) return;
  const fs::path file = folder / kJournalFile;
  Part part{folder, RunHeader::of(journal->header, file), std::move(journal->records)};
  if (!part.header.shard) {
    throw Error(Error::kInvalidArgument,
                "'" + folder.string() +
                    "' has an unfinished run of its own, no shard; --resume "
                    "goes on with it");
  }
  if (!parts_.empty()) {
    const Part& first = parts_.front();
    // The number of the shard alone may differ.
    RunHeader other = part.header;
    RunHeader one = first.header;
    if (one.shard->count == other.shard->count) one.shard = other.shard;
    require_same_run(one.document(), "'" + first.folder.string() + "'", other.document(),
                     "'" + folder.string() + "'");
    const auto twin = std::ranges::find_if(
        parts_, [&](const Part& before) { return before.header.shard == part.header.shard; });
    if (twin != parts_.end()) {
      throw Error(Error::kInvalidArgument,
                  "shard " + to_text(*part.header.shard) + " given twice, '" +
                      twin->folder.string() + "' and '" + folder.string() + "'; each once allowed");
    }
  }
  parts_.push_back(std::move(part));
}

std::vector<MissingShard> ShardSet::missing() const {
  std::vector<MissingShard> missing;
  const int count = header().shard->count;
  std::vector<const Part*> by_number(static_cast<std::size_t>(count), nullptr);
  for (const Part& part : parts_) {
    by_number[static_cast<std::size_t>(part.header.shard->number) - 1] = &part;
  }
  const std::vector<std::vector<EpisodeRange>> shares = all_shares(header().loads(), count);
  for (int number = 1; number <= count; ++number) {
    const Shard shard{number, count};
    const auto i = static_cast<std::size_t>(number) - 1;
    const Part* part = by_number[i];
    const int episodes =
        episodes_missing(header(), shares[i], part == nullptr ? nullptr : &part->records);
    if (episodes == 0) continue;
    missing.push_back(
        {shard, episodes, (part == nullptr ? header() : part->header).command_of(shard)});
  }
  return missing;
}

}  // namespace engram
