#include "protocol/eval/results/result_files.h"

#include <catch2/catch.hpp>
#include <functional>

#include "protocol/eval/results/result_check.h"
#include "protocol/io/files.h"
#include "protocol/io/json_checksum.h"
#include "tests/temporary_folder.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

constexpr const char* kId = "RememberColor3-VLA-v0";

EvaluationSettings settings_of(Json policy_config) {
  EvaluationSettings settings;
  settings.tasks = {kId};
  settings.episodes = 2;
  settings.policy = "mine";
  settings.policy_config = std::move(policy_config);
  return settings;
}

TaskResult result() {
  TaskResult result;
  result.entry = &require_entry(kId);
  result.chance = 1.0 / 3;
  result.answer_chance = 1.0 / 3;
  result.successes = {true, false};
  result.returns = {12.5, 0.1};
  result.lengths = {25, 25};
  result.answers = {{1, 2, 1}, {}};
  result.completions = {{4, 4}, {2, 4}};
  result.seeds = {kBenchmarkSeed, kBenchmarkSeed + 1};
  result.digests = {{1, 2, 3, 4}, {UINT64_MAX, 0, 0, 0}};
  return result;
}

struct Folder {
  test::TemporaryFolder folder;
  EvaluationSettings settings = settings_of(JsonTable{{"command", "x"}});
  Json document = task_document(result(), settings);

  ResultFolder open() const { return ResultFolder::open(folder.path()); }
  void write(const Json& task) const {
    write_file(folder.path() / (std::string(kId) + ".json"), to_text(task));
  }
  bool accepts(const Json& task) const {
    write(task);
    return open().finished(settings).contains(kId);
  }
};

// The document with one value changed; the checksum fits what was changed if that is wanted.
Json edited(const Json& document, std::string_view key, Json value, bool checked) {
  JsonTable all = table(document);
  for (auto& [name, old] : all) {
    if (name == key) old = value;
  }
  if (checked) {
    all.pop_back();
    all.emplace_back("checksum", document_checksum(all));
  }
  return all;
}

TEST_CASE("Results survive their document", "[evaluation][results]") {
  const Folder folder;
  const auto read = parse_result(folder.document, require_entry(kId));
  REQUIRE(read);
  CHECK((task_document(*read, folder.settings) == folder.document));
  CHECK(folder.accepts(folder.document));
}

TEST_CASE("Edited results are refused", "[evaluation][results]") {
  const Folder folder;
  const Json seeds = JsonList{1, 2};
  const std::pair<const char*, Json> edits[] = {{"split", "Long"},
                                                {"memory_type", "Spatial"},
                                                {"successes", JsonList{true, true}},
                                                {"returns", JsonList{99.5, 99.5}},
                                                {"sr", 1.0},
                                                {"mean_return", 99.0},
                                                {"benchmark_commit", "abc"},
                                                {"wrapper_chain", "none"},
                                                {"action_chunk_size", 8},
                                                {"episode_lengths", JsonList{7, 7}},
                                                {"episode_seeds", seeds},
                                                {"chance", 0.9},
                                                {"first_answers", JsonList{1, nullptr}},
                                                {"first_answer_correct", 1.0},
                                                {"memory_score", 1.0},
                                                {"subtasks_done", JsonList{4, 3}},
                                                {"completion_rate", 1.0},
                                                {"sr_interval", JsonList{0, 1}},
                                                {"digests", nullptr},
                                                {"checksum", "0000000000000000"}};
  for (const auto& [key, value] : edits) {
    INFO(key);
    REQUIRE(find(folder.document, key) != nullptr);
    CHECK_FALSE(folder.accepts(edited(folder.document, key, value, false)));
  }
  JsonTable more = table(folder.document);
  more.emplace_back("note", "by hand");
  CHECK_FALSE(folder.accepts(more));
}

TEST_CASE("Inconsistent results with a valid checksum are refused", "[evaluation][results]") {
  const Folder folder;
  const std::pair<const char*, Json> edits[] = {{"split", "Long"},
                                                {"sr", 1.0},
                                                {"mean_return", 99.0},
                                                {"episode_lengths", JsonList{25, 26}},
                                                {"episode_lengths", JsonList{0, 25}},
                                                {"episode_seeds", JsonList{1, 2}},
                                                {"memory_score", 1.0},
                                                {"completion_rate", 1.0},
                                                {"subtasks", JsonList{4}},
                                                {"first_answer_correct", 1.0}};
  for (const auto& [key, value] : edits) {
    INFO(key);
    CHECK_FALSE(folder.accepts(edited(folder.document, key, value, true)));
  }
}

TEST_CASE("Results of another version are refused for every policy", "[evaluation][results]") {
  for (const Json& config : {Json(), Json(JsonTable{{"command", "x"}})}) {
    Folder folder;
    folder.settings = settings_of(config);
    const Json document = task_document(result(), folder.settings);
    CHECK(text(part(document, "version")) == version());
    folder.write(edited(document, "version", "99.0.0", true));
    CHECK_THROWS_WITH(
        folder.open().finished(folder.settings),
        Catch::Contains("has version \"99.0.0\", this run") && Catch::Contains(version()));
    JsonTable nameless = table(document);
    std::erase_if(nameless, [](const auto& entry) { return entry.first == "version"; });
    folder.write(nameless);
    CHECK_THROWS_WITH(folder.open().finished(folder.settings),
                      Catch::Contains("has version null, this run"));
  }
}

TEST_CASE("A folder of results is one run's at a time", "[evaluation][results]") {
  const Folder folder;
  {
    const ResultFolder one = folder.open();
    const ResultFolder copy = one;  // the same run
    CHECK_THROWS_WITH(folder.open(), Catch::Contains("is in use by process"));
  }
  CHECK_NOTHROW(folder.open());
}

TEST_CASE("A run goes on in its folder when a link takes its name", "[evaluation][results]") {
  const Folder folder;
  const test::TemporaryFolder elsewhere;
  const fs::path run = folder.folder.path() / "run";
  fs::create_directories(run);
  const ResultFolder open = ResultFolder::open(run);
  fs::rename(run, folder.folder.path() / "moved");
  fs::create_directory_symlink(elsewhere.path(), run);
  open.begin(folder.settings);
  open.write_task(folder.document);
  open.write_summary({folder.document});
  open.add_timing(kId, 1);
  open.write_sample(kId, Bytes(3));
  open.write_report("<html>");
  CHECK(fs::is_empty(elsewhere.path()));
  CHECK(fs::exists(folder.folder.path() / "moved" / (std::string(kId) + ".json")));
  // Nor does a link that takes the place of its images lead out of it.
  fs::remove_all(folder.folder.path() / "moved" / "samples");
  fs::create_directory_symlink(elsewhere.path(), folder.folder.path() / "moved" / "samples");
  CHECK_THROWS_WITH(open.write_sample(kId, Bytes(3)), Catch::Contains("leads elsewhere"));
  CHECK(fs::is_empty(elsewhere.path()));
}

TEST_CASE("Summaries are tables, too", "[evaluation][results]") {
  const Folder folder;
  folder.open().write_summary({folder.document});
  const std::string table = test::read_file(folder.folder.path() / "summary.csv");
  CHECK_THAT(table, Catch::StartsWith("env_id,split,memory_type,n_episodes,sr,chance,memory_score,"
                                      "first_answer_correct,mean_return,mean_length,sr_low,"
                                      "sr_high\n"
                                      "RememberColor3-VLA-v0,Short,Object,2,0.5,0.333"));
  CHECK_THAT(table, Catch::Contains(",0.5,6.3,25.0,0.094531205734"));
}

TEST_CASE("Images that lead out of the folder are not followed", "[evaluation][results]") {
  const Folder folder;
  const test::TemporaryFolder elsewhere;
  const fs::path theirs = elsewhere.path() / "RememberColor3-VLA-v0.png.1.engram-tmp";
  std::ofstream(theirs) << "theirs";
  fs::create_directory_symlink(elsewhere.path(), folder.folder.path() / "samples");
  CHECK_THROWS_WITH(folder.open(), Catch::Contains("samples' leads elsewhere"));
  CHECK(fs::exists(theirs));
}

TEST_CASE("Results of repeats say so, and are as many as all rounds", "[evaluation][results]") {
  Folder folder;
  folder.settings.repeat = 2;
  folder.settings.policy_seed = 7;
  folder.settings.latency = 3;
  TaskResult twice = result();
  const TaskResult once = twice;
  twice.successes = {true, false, false, false};
  for (auto* values : {&twice.lengths}) values->insert(values->end(), {25, 25});
  twice.returns.insert(twice.returns.end(), {1, 2});
  twice.answers.insert(twice.answers.end(), once.answers.begin(), once.answers.end());
  twice.completions.insert(twice.completions.end(), once.completions.begin(),
                           once.completions.end());
  twice.seeds.insert(twice.seeds.end(), once.seeds.begin(), once.seeds.end());
  twice.digests.insert(twice.digests.end(), once.digests.begin(), once.digests.end());
  const Json document = task_document(twice, folder.settings);
  CHECK(whole_number(part(document, "n_episodes")) == 4);
  CHECK(whole_number(part(document, "repeat")) == 2);
  CHECK(whole_number(part(document, "policy_seed")) == 7);
  CHECK(whole_number(part(document, "latency_steps")) == 3);
  CHECK((list(part(document, "episode_seeds"))[3] == Json(kBenchmarkSeed + 1)));
  CHECK(folder.accepts(document));
  // Results of one round are of another protocol.
  folder.write(folder.document);
  CHECK_THROWS_WITH(folder.open().finished(folder.settings),
                    Catch::Contains("has n_episodes 2, this run 4"));
  folder.settings.latency = 0;
  folder.write(document);
  CHECK_THROWS_WITH(folder.open().finished(folder.settings),
                    Catch::Contains("has latency_steps 3, this run null"));
}

TEST_CASE("Summaries have intervals of tasks, splits and all", "[evaluation][results]") {
  const Folder folder;
  const Json summary = summary_document({folder.document});
  const Json& interval = part(summary, "sr_interval");
  CHECK(number(list(interval)[0]) == Approx(0.0945312057344231));
  CHECK(number(list(interval)[1]) == Approx(0.9054687942655769));
  CHECK((part(part(part(summary, "splits"), "Short"), "sr_interval") == interval));
  CHECK((part(part(summary, "per_task_sr_interval"), kId) == interval));
  CHECK((part(folder.document, "sr_interval") == interval));
}

}  // namespace
}  // namespace engram
