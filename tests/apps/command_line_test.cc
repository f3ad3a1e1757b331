#include "apps/command_line.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"

namespace engram::apps {
namespace {

struct Parsed {
  std::string name = "default";
  double rate = 1;
  bool loud = false;
  std::vector<std::string> words;
  bool given = false;
  int runs = 0;
};

// A program with one command, `say`.
Parsed parse(const std::vector<std::string>& words, std::string* text = nullptr) {
  Parsed parsed;
  CommandLine line("program", "A program");
  line.set_version("program 1.0");
  line.require_command();
  const Command say = line.program().add_command("say", "Says words");
  say.add_option("--name", parsed.name, "A name");
  say.add_positive("--rate", parsed.rate, "A rate");
  say.add_flag("--loud", parsed.loud, "Loudly");
  say.add_repeatable(
      "--word", [&parsed](const std::string& word) { parsed.words.push_back(word); }, "A word");
  say.add_option("--secret", parsed.name, "A name that the help does not have");
  say.hide_option("--secret");
  say.when_parsed([&] { parsed.given = say.given("--name"); });
  say.on_run([&parsed] { ++parsed.runs; });
  const std::string shown = line.parse(words);
  if (text != nullptr) *text = shown;
  return parsed;
}

TEST_CASE("A command gets its options and runs once", "[apps][command_line]") {
  const Parsed parsed =
      parse({"say", "--name", "x", "--rate", "2.5", "--loud", "--word", "a", "--word", "b"});
  CHECK(parsed.name == "x");
  CHECK(parsed.rate == 2.5);
  CHECK(parsed.loud);
  CHECK(parsed.words == std::vector<std::string>{"a", "b"});
  CHECK(parsed.given);
  CHECK(parsed.runs == 1);
  CHECK_FALSE(parse({"say"}).given);
}

TEST_CASE("Help and version are texts, and nothing runs", "[apps][command_line]") {
  std::string text;
  CHECK(parse({"--version"}, &text).runs == 0);
  CHECK(text == "program 1.0\n");
  CHECK(parse({"say", "--help"}, &text).runs == 0);
  CHECK_THAT(text, Catch::Contains("--rate") && Catch::Contains("A rate"));
  CHECK_THAT(text, !Catch::Contains("--secret"));
  CHECK(parse({"say", "--secret", "x"}).name == "x");
  CHECK_THROWS_WITH(parse({"say", "--secret"}), Catch::Contains("--secret"));
}

TEST_CASE("Words that are not allowed are refused", "[apps][command_line]") {
  CHECK_THROWS_AS(parse({}), Error);
  CHECK_THROWS_AS(parse({"sing"}), Error);
  CHECK_THROWS_AS(parse({"say", "--volume", "3"}), Error);
  CHECK_THROWS_AS(parse({"say", "--rate", "0"}), Error);
  CHECK_THROWS_AS(parse({"say", "--name", ""}), Error);
}

TEST_CASE("A misspelt command or option leads to the nearest one", "[apps][command_line]") {
  CHECK_THROWS_WITH(parse({"sya"}), Catch::Contains("no command 'sya'; did you mean 'say'?"));
  CHECK_THROWS_WITH(parse({"say", "--lowd"}), Catch::Contains("did you mean '--loud'?"));
  CHECK_THROWS_WITH(parse({"recollect"}), !Catch::Contains("did you mean"));
  CHECK_THROWS_WITH(parse({"say", "--secre"}), !Catch::Contains("secret'?"));
}

}  // namespace
}  // namespace engram::apps
