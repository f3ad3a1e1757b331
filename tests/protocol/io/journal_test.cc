#include "protocol/io/journal.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "tests/temporary_folder.h"

namespace engram {
namespace {

const JsonTable kHeader = {{"kind", "eval"}, {"run", JsonTable{{"seed", 7}, {"ids", "a"}}}};

Bytes bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

// A folder whose journal has three records.
struct Written {
  test::TemporaryFolder folder;
  OpenFolder opened{folder.path()};
  std::filesystem::path file = folder.path() / kJournalFile;

  Written() {
    Journal journal(opened, kHeader);
    journal.add("a", 3, bytes_of("three"));
    journal.add("a", 0, bytes_of("zero"));
    journal.add("b", 3, bytes_of(""));
  }
};

TEST_CASE("Journal: what is added is there again", "[journal]") {
  const Written written;
  Journal journal(written.opened, kHeader);
  CHECK(journal.size() == 3);
  CHECK(journal.records().at("a").at(3) == bytes_of("three"));
  CHECK(journal.records().at("b").at(3).empty());
  journal.add("c", 1, bytes_of("one"));
  const auto content = read_journal(written.opened);
  REQUIRE(content);
  CHECK(content->header == Json(kHeader));
  CHECK(content->records == journal.records());
  journal.remove();
  CHECK_FALSE(std::filesystem::exists(written.file));
}

TEST_CASE("Journal: a torn end is cut off, whole records stay", "[journal]") {
  const Written whole;
  const std::string text = test::read_file(whole.file);
  std::size_t before = 0;
  bool all = false;
  // From the end of the header on.
  const std::size_t header = text.find("\"ids\":\"a\"}}") + 11;
  for (std::size_t size = header; size <= text.size(); ++size) {
    test::TemporaryFolder folder;
    const OpenFolder opened(folder.path());
    opened.write_file(kJournalFile, std::string_view(text).substr(0, size));
    Journal journal(opened, kHeader);
    CHECK(journal.size() >= before);
    before = journal.size();
    all = before == 3;
    CHECK(std::filesystem::file_size(folder.path() / kJournalFile) <= size);
    journal.add("d", 0, bytes_of("new"));
    CHECK(read_journal(opened)->records == journal.records());
  }
  CHECK(all);
}

TEST_CASE("Journal: nothing behind a damaged byte counts", "[journal]") {
  const Written written;
  std::string text = test::read_file(written.file);
  text[text.find("zero")] ^= 1;
  written.opened.write_file(kJournalFile, text);
  const Journal journal(written.opened, kHeader);
  CHECK(journal.size() == 1);
  CHECK(journal.records().at("a").contains(3));
}

TEST_CASE("Journal: records in another order are damage", "[journal]") {
  const Written written;
  std::string text = test::read_file(written.file);
  const std::size_t third = text.size() - (12 + 4 + 1 + 4);
  const std::size_t second = third - (12 + 4 + 1 + 4 + 4);
  const std::string moved =
      text.substr(0, second) + text.substr(third) + text.substr(second, third - second);
  written.opened.write_file(kJournalFile, moved);
  CHECK(Journal(written.opened, kHeader).size() == 1);
}

TEST_CASE("Journal: that of another run, and other files, are refused and unchanged", "[journal]") {
  const Written written;
  const std::string before = test::read_file(written.file);
  JsonTable other = kHeader;
  other[1].second = JsonTable{{"seed", 8}, {"ids", "a"}};
  CHECK_THROWS_WITH(Journal(written.opened, other),
                    Catch::Contains("has seed 7") && Catch::Contains("this run 8"));
  CHECK(test::read_file(written.file) == before);
  written.opened.write_file(kJournalFile, std::string_view("my notes"));
  CHECK_THROWS_WITH(Journal(written.opened, kHeader), Catch::Contains("is not a journal"));
  written.opened.write_file(kJournalFile, std::string_view(before).substr(0, 30));
  CHECK_THROWS_WITH(Journal(written.opened, kHeader), Catch::Contains("damaged at its beginning"));
}

TEST_CASE("Journal: one without records gives way to that of another run", "[journal]") {
  const test::TemporaryFolder folder;
  const OpenFolder opened(folder.path());
  { const Journal journal(opened, kHeader); }
  const JsonTable other = {{"kind", "probe"}};
  CHECK(Journal(opened, other).size() == 0);
  CHECK(read_journal(opened)->header == Json(other));
}

TEST_CASE("Journal: the words of a command and checksums make no other run", "[journal]") {
  const Json one = JsonTable{{"command", "a"}, {"run", JsonTable{{"checksum", "1"}}}};
  const Json other = JsonTable{{"command", "b"}, {"run", JsonTable{{"checksum", "2"}}}};
  CHECK_NOTHROW(require_same_run(one, "'x'", other, "'y'"));
  const Json more = JsonTable{{"command", "a"}, {"run", JsonTable{{"physics", "engram"}}}};
  CHECK_THROWS_WITH(require_same_run(one, "'x'", more, "'y'"),
                    Catch::Contains("'x' has physics null, 'y' \"engram\""));
}

}  // namespace
}  // namespace engram
