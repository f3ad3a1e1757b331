// The folder of an interrupted evaluation: settings, results and times of any content.
#include <map>
#include <string>

#include "protocol/eval/evaluation_run.h"
#include "protocol/eval/results/comparison.h"
#include "protocol/eval/results/result_tables.h"
#include "protocol/io/json_checksum.h"
#include "tests/fuzz/input.h"

namespace engram::fuzz {

// Placeholder of the version in the corpus, which is older than most versions.
std::string with_version(std::string_view text) {
  constexpr std::string_view kMark = "@version@";
  std::string all(text);
  if (const std::size_t at = all.find(kMark); at != std::string::npos) {
    all.replace(at, kMark.size(), version());
  }
  return all;
}

// With its checksum, without which no settings are read; every second text as it is.
std::string with_checksum(const std::string& text) {
  const std::optional<Json> document = parse_json(text);
  if (!document || !is_table(*document) || text.size() % 2 == 0) return text;
  JsonTable all = table(*document);
  std::erase_if(all, [](const auto& entry) { return entry.first == "checksum"; });
  add_checksum(all);
  return to_text(all);
}

// The bytes are three files, separated by zeros.
void fuzz_results(Data data) {
  static const Folder folder;
  static std::map<std::string, std::string> written;
  Input input(data);
  std::string_view rest = input.rest_text();
  for (const char* name : {"settings.json", "RememberColor3-VLA-v0.json", "timing.json"}) {
    const std::size_t end = std::min(rest.find('\0'), rest.size());
    const std::string text = with_checksum(with_version(rest.substr(0, end)));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    const auto [before, fresh] = written.try_emplace(name, text);
    if (!fresh && before->second == text) continue;
    put_file(folder.path() / name, text);
    before->second = text;
  }
  EvaluationSettings settings;
  settings.tasks = {"RememberColor3-VLA-v0"};
  settings.episodes = 2;
  settings.policy = "oracle";
  const ResultFolder results = ResultFolder::open(folder.path());
  accepted([&] {
    if (const auto found = results.settings()) settings = *found;
  });
  accepted([&] {
    written.erase("settings.json");                         // the run writes its own
    std::filesystem::remove(folder.path() / kJournalFile);  // of another input
    EvaluationRun run(settings, results);
    (void)run.open_tasks();
    (void)to_text(run.document());
    // Writing what was read takes much longer than reading it.
    if (data.size() % 32 == 0) run.finish("fuzz");
  });
  accepted([&] {
    const ResultSet found = read_results(folder.path());
    for (std::size_t i = 0; i < kTableFormatNames.size(); ++i) {
      (void)result_table(static_cast<TableFormat>(i), found.tasks);
    }
    (void)to_text(compare_results(found, found, {}));
  });
}

}  // namespace engram::fuzz
