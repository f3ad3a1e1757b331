// Edited folders: sound settings, results and metadata with other values in some
// places, or links, pipes and folders in place of files.
#include <sys/stat.h>

#include <array>
#include <limits>
#include <vector>

#include "protocol/datasets/demonstration_folder.h"
#include "protocol/eval/evaluation_run.h"
#include "protocol/io/json_checksum.h"
#include "tests/fuzz/input.h"

namespace engram::fuzz {
namespace {

namespace fs = std::filesystem;
using std::string_literals::operator""s;

constexpr const char* kId = "RememberColor3-VLA-v0";

EvaluationSettings sound_settings() {
  EvaluationSettings settings;
  settings.tasks = {kId};
  settings.episodes = 2;
  settings.policy = "mine";
  settings.policy_config = JsonTable{{"command", "true"}};
  settings.set_environment({});
  return settings;
}

Json sound_result() {
  TaskResult result;
  result.entry = &require_entry(kId);
  result.successes = {true, false};
  result.returns = {1.5, 0};
  result.lengths = {25, 25};
  result.answers = {{1, 2, 1}, {}};
  result.seeds = {kBenchmarkSeed, kBenchmarkSeed + 1};
  return task_document(result, sound_settings());
}

Json sound_metadata() {
  const Folder root;
  return DemonstrationFolder(root.path(), require_entry(kId), {.episodes = 3, .max_attempts = 9})
      .metadata();
}

// --- edits ---

Json any_value(Input& input) {
  const Json values[] = {nullptr,
                         true,
                         0,
                         -1,
                         1e300,
                         2.5,
                         1'000'000'000'000,
                         std::numeric_limits<std::int64_t>::min(),
                         std::numeric_limits<std::uint64_t>::max(),
                         "",
                         "../../outside/victim",
                         "RememberColor3-VLA-v0\0x"s,
                         "\x1b[2J",
                         std::string(5000, 'x'),
                         "touch ../outside/victim",
                         "oracle",
                         "rgb",
                         JsonList(),
                         JsonList(3, JsonList{1}),
                         JsonTable(),
                         JsonTable{{"command", "touch ../outside/victim"}}};
  const int choice = input.choice(std::size(values) + 2);
  if (choice < static_cast<int>(std::size(values))) return values[choice];
  return choice % 2 == 0 ? Json(input.take<double>()) : Json(input.text());
}

// Walks into the document by the input's choice and changes what it comes to.
void edit(Json& document, Input& input) {
  if (auto* table = std::get_if<JsonTable>(&document.value); table && !table->empty()) {
    const auto at = static_cast<std::size_t>(input.choice(table->size()));
    switch (input.choice(8)) {
      case 0:
        table->erase(table->begin() + static_cast<std::ptrdiff_t>(at));
        return;
      case 1:
        table->emplace_back((*table)[at].first, any_value(input));
        return;
      case 2:
        (*table)[at].first = input.text();
        return;
      default:
        edit((*table)[at].second, input);
        return;
    }
  }
  if (auto* list = std::get_if<JsonList>(&document.value); list && !list->empty()) {
    const int choice = input.choice(list->size() + 2);
    if (choice < static_cast<int>(list->size())) {
      edit((*list)[static_cast<std::size_t>(choice)], input);
    } else if (choice % 2 == 0) {
      list->pop_back();
    } else {
      list->push_back(any_value(input));
    }
    return;
  }
  document = any_value(input);
}

// --- files ---

// Folders for one input, and beside them what must stay as it is.
struct Place {
  Folder root;
  fs::path results = root.path() / "results";
  fs::path data = root.path() / "data_npz" / kId;
  fs::path outside = root.path() / "outside";

  Place() {
    fs::create_directories(results);
    fs::create_directories(data);
    fs::create_directories(outside);
    put_file(outside / "victim", "precious");
  }
  void check() const {
    int count = 0;
    for (const auto& entry : fs::directory_iterator(outside)) {
      count += entry.is_regular_file() ? 1 : 2;
    }
    require(count == 1 && fs::file_size(outside / "victim") == 8, "something outside was changed");
  }
};

// The document in the file, or something that is no file of engram's.
void put(const Place& place, const fs::path& path, const Json& document, int form) {
  std::error_code ignored;
  fs::remove_all(path, ignored);
  switch (form) {
    case 0:
      fs::create_symlink(place.outside / "victim", path);
      return;
    case 1:
      fs::create_symlink("/dev/zero", path);
      return;
    case 2:
      require(::mkfifo(path.c_str(), 0600) == 0, "no pipe");
      return;
    case 3:
      fs::create_directory_symlink(place.outside, path);
      return;
    case 4:
      fs::create_directory(path);
      return;
    default:
      put_file(path, to_text(document));
  }
}

void check_results(const Place& place, const Json& sound) {
  accepted([&] {
    const ResultFolder folder = ResultFolder::open(place.results);
    EvaluationSettings settings = folder.settings().value_or(sound_settings());
    require(settings.tasks.size() < 1000, "tasks");
    EvaluationRun run(std::move(settings), folder);
    (void)run.open_tasks();
    for (const Json& task : run.tasks()) require(task == sound, "an edited result is taken");
    run.finish("fuzz");
  });
}

void check_metadata(const Place& place) {
  accepted([&] {
    const DemonstrationFolder folder(place.root.path(), require_entry(kId),
                                     {.episodes = 3, .max_attempts = 9});
    require(folder.episodes() == 0, "episodes that are not there");
  });
}

// An edit by a user who knows the checksum.
Json with_checksum(const Json& edited) {
  JsonTable all = table(edited);
  std::erase_if(all, [](const auto& entry) { return entry.first == "checksum"; });
  add_checksum(all);
  return all;
}

}  // namespace

void fuzz_edits(Data data) {
  static const Place place;
  static const Json settings = sound_settings().document();
  static const Json result = sound_result();
  static const Json metadata = sound_metadata();
  Input input(data);
  const int what = input.choice(4);
  const std::pair<fs::path, const Json*> files[] = {
      {place.results / "settings.json", &settings},
      {place.results / (std::string(kId) + ".json"), &result},
      {place.data / "metadata.json", &metadata},
      {place.results / "samples", &settings}};
  std::error_code ignored;
  fs::remove_all(place.results / "samples", ignored);
  for (std::size_t i = 0; i < 3; ++i) {
    if (static_cast<int>(i) != what) put(place, files[i].first, *files[i].second, 9);
  }
  const auto& [path, sound] = files[what];
  Json edited = *sound;
  const int form = input.choice(what == 3 ? 5 : 40);
  for (int edits = 1 + input.choice(3); edits > 0; --edits) edit(edited, input);
  // Results with a forged checksum may be consistent.
  if (what != 1 && is_table(edited) && input.choice(2) == 0) edited = with_checksum(edited);
  put(place, path, edited, form);
  if (what == 2) {
    check_metadata(place);
  } else {
    check_results(place, result);
  }
  place.check();
}

}  // namespace engram::fuzz
