#include "protocol/eval/results/result_set.h"

#include <catch2/catch.hpp>

#include "protocol/io/files.h"
#include "tests/protocol/eval/results/evaluation_documents.h"
#include "tests/temporary_folder.h"

namespace engram {
namespace {

using Catch::Contains, test::task_of, test::with_value;

constexpr const char* kId = "RememberColor3-VLA-v0";

// A document without a key, as older versions wrote it.
Json without(const Json& document, std::string_view key) {
  JsonTable all = table(document);
  all.pop_back();
  std::erase_if(all, [key](const auto& entry) { return entry.first == key; });
  add_checksum(all);
  return all;
}

TEST_CASE("Results are read from folders, files and texts", "[evaluation][results]") {
  const test::TemporaryFolder folder;
  const Json later = task_of("TakeItBack-VLA-v0", {true, false});
  const Json first = task_of(kId, {true, true});
  write_file(folder.path() / "TakeItBack-VLA-v0.json", to_text(later));
  write_file(folder.path() / (std::string(kId) + ".json"), to_text(first));
  write_file(folder.path() / "summary.json", to_text(summary_document({first, later})));
  write_file(folder.path() / "timing.json", "{}");
  write_file(folder.path() / "notes.json", "not JSON");
  CHECK((read_results(folder.path()).tasks == JsonList{first, later}));
  CHECK((read_results(folder.path() / "TakeItBack-VLA-v0.json").tasks == JsonList{later}));
  const std::string whole =
      to_text(JsonTable{{"summary", summary_document({later})}, {"tasks", JsonList{later, first}}});
  CHECK((read_results(whole).tasks == JsonList{first, later}));
  CHECK(read_results(whole).source == "document");
  write_file(folder.path() / "whole", whole);
  CHECK(read_results(folder.path() / "whole").tasks.size() == 2);
}

TEST_CASE("Results of older versions are read", "[evaluation][results]") {
  Json old = with_value(task_of(kId, {true, false}), "version", "0.4.0");
  for (const char* key : {"digests", "sr_interval"}) old = without(old, key);
  CHECK((read_results(to_text(old)).tasks == JsonList{old}));
}

TEST_CASE("What is no result is refused with its name", "[evaluation][results]") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path();
  const auto refuse = [](const std::string& source, const auto& words) {
    INFO(source);
    CHECK_THROWS_WITH(read_results(source), words);
  };
  refuse(path, Contains("'" + path + "': a folder without results"));
  refuse(path + "/none", Contains("'" + path + "/none' does not exist"));
  refuse("{", Contains("a JSON object needed"));
  refuse("{}", Contains("no results of an evaluation"));
  refuse(R"({"env_id": 3})", Contains("no result of an evaluation"));
  const Json task = task_of(kId, {true, false});
  JsonTable edited = table(task);
  edited[7].second = 1.0;  // sr
  refuse(to_text(edited), Contains("the checksum of RememberColor3-VLA-v0 does not fit"));
  refuse(to_text(with_value(task, "successes", JsonList{true})),
         Contains("'successes' of RememberColor3-VLA-v0 is not complete"));
  refuse(to_text(with_value(task, "successes", JsonList{1, 2})),
         Contains("no result of an evaluation"));
  refuse(to_text(without(task, "model")), Contains("no 'model'"));
  refuse(to_text(JsonTable{{"summary", nullptr}, {"tasks", JsonList{task, task}}}),
         Contains("RememberColor3-VLA-v0 is there twice"));
  refuse(to_text(JsonTable{{"summary", nullptr}, {"tasks", JsonList{}}}), Contains("no tasks"));
}

}  // namespace
}  // namespace engram
