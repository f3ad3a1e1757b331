#include "protocol/eval/results/result_set.h"

#include <algorithm>
#include <filesystem>

#include "protocol/eval/policies/episode_digests.h"
#include "protocol/eval/results/success_rates.h"
#include "protocol/io/files.h"
#include "protocol/io/json_checksum.h"
#include "protocol/make/make.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const std::string& source, const std::string& what) {
  throw Error(Error::kInvalidArgument, "'" + source + "': " + what);
}

bool is_task(const Json& document) { return find(document, "env_id") != nullptr; }

// Throws Error unless a list of a task has an item for each episode.
void check_list(const std::string& source, const Json& task, const Json& items, const char* key) {
  if (list(items).size() == whole_number(part(task, "n_episodes"))) return;
  refuse(source,
         "'" + std::string(key) + "' of " + text(part(task, "env_id")) + " is not complete");
}

// The lists that every task has, and those that may be null or missing.
void check_lists(const std::string& source, const Json& task) {
  for (const char* key : {"successes", "returns", "episode_lengths"}) {
    check_list(source, task, part(task, key), key);
  }
  for (const Json& success : list(part(task, "successes"))) (void)truth(success);
  for (const char* key :
       {"episode_seeds", "first_answers", "first_answers_correct", "subtasks_done", "subtasks"}) {
    const Json* items = find(task, key);
    if (items != nullptr && !is_null(*items)) check_list(source, task, *items, key);
  }
  const Json* digests = find(task, "digests");
  if (digests == nullptr || is_null(*digests)) return;
  for (const auto& [key, field] : kDigestKeys) check_list(source, task, part(*digests, key), key);
}

// Throws Error unless the document has what tables and comparisons read, as it was written.
void check_task(const std::string& source, const Json& task) {
  try {
    const std::string& id = text(part(task, "env_id"));
    if (!has_valid_checksum(task)) {
      refuse(source, "the checksum of " + id + " does not fit: it was edited");
    }
    for (const char* key : {"split", "memory_type", "version", "rules", "obs_mode"})
      (void)text(part(task, key));
    for (const char* key : {"chance", "memory_score", "first_answer_correct"})
      (void)part(task, key);
    (void)text(part(part(task, "model"), "name"));
    (void)number(part(task, "sr"));
    (void)number(part(task, "mean_return"));
    check_lists(source, task);
    const std::uint64_t episodes = whole_number(part(task, "n_episodes"));
    if (episodes == 0 || episodes % static_cast<std::uint64_t>(repeats_of(task)) != 0) {
      refuse(source, id + " has " + std::to_string(episodes) + " episodes in " +
                         std::to_string(repeats_of(task)) + " rounds");
    }
  } catch (const Error& error) {
    if (error.kind() != Error::kIo) throw;
    refuse(source, std::string("no result of an evaluation: ") + error.what());
  }
}

Json parse(const std::string& source, const std::string& text) {
  std::optional<Json> document = parse_json(text);
  if (!document || !is_table(*document)) refuse(source, "a JSON object needed");
  return *std::move(document);
}

void add_document(const std::string& source, const Json& document, JsonList& tasks) {
  if (is_task(document)) {
    tasks.push_back(document);
  } else if (const Json* all = find(document, "tasks");
             all != nullptr && find(document, "summary") != nullptr) {
    for (const Json& task : list(*all)) tasks.push_back(task);
  } else {
    refuse(source,
           "no results of an evaluation: a folder of `engram eval --out`, a task's file in "
           "it, or what `engram eval --json` prints needed");
  }
}

void add_folder(const fs::path& folder, JsonList& tasks) {
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".json") continue;
    const std::optional<std::string> text = read_file(entry.path());
    const std::optional<Json> document = text ? parse_json(*text) : std::nullopt;
    if (document && is_task(*document)) tasks.push_back(*document);
  }
  if (tasks.empty()) {
    refuse(folder.string(),
           "a folder without results; that of a run needed, as in "
           "RESULTS/<split>/<date_time>");
  }
}

// Ids that the registry does not know, such as variants, come last.
int place_of(const Json& task) {
  const RegistryEntry* entry = find_entry(text(part(task, "env_id")));
  return entry == nullptr ? INT_MAX : entry->index;
}

}  // namespace

ResultSet read_results(const std::string& source) {
  ResultSet results{source, {}};
  if (source.starts_with('{')) {
    results.source = "document";
    add_document(results.source, parse(results.source, source), results.tasks);
  } else if (std::error_code none; fs::is_directory(source, none)) {
    add_folder(source, results.tasks);
  } else {
    const std::optional<std::string> text = read_input(source);
    if (!text) throw Error(Error::kIo, "'" + source + "' does not exist");
    add_document(source, parse(source, *text), results.tasks);
  }
  if (results.tasks.empty()) refuse(results.source, "no tasks in it");
  for (const Json& task : results.tasks) check_task(results.source, task);
  std::ranges::sort(results.tasks, {}, [](const Json& task) {
    return std::pair(place_of(task), text(part(task, "env_id")));
  });
  for (std::size_t i = 1; i < results.tasks.size(); ++i) {
    const std::string& id = text(part(results.tasks[i], "env_id"));
    if (id == text(part(results.tasks[i - 1], "env_id")))
      refuse(results.source, id + " is there twice");
  }
  return results;
}

}  // namespace engram
