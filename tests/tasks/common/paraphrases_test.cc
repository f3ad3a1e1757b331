#include "tasks/common/paraphrases.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/batch/queries.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

// The words of a text, in lower case.
std::set<std::string> words_of(const std::string& text) {
  std::set<std::string> words;
  std::string word;
  for (const char c : text + " ") {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '{' || c == '}' || c == '_') {
      word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    } else if (!word.empty()) {
      words.insert(std::exchange(word, {}));
    }
  }
  return words;
}

// Words that would tell something of the scene.
const std::set<std::string> kTelling = {
    "red",    "green",    "blue",   "black",       "white",  "yellow", "left",    "right",
    "middle", "lamp",     "button", "disc",        "socket", "slot",   "cube",    "cubes",
    "cup",    "cups",     "ball",   "peg",         "center", "table",  "handle",  "circle",
    "square", "triangle", "cross",  "sphere",      "torus",  "target", "battery", "one",
    "two",    "three",    "twice",  "{angle_deg}", "{steps}"};

std::set<std::string> telling_words(const std::string& text) {
  std::set<std::string> found;
  for (const std::string& word : words_of(text)) {
    if (kTelling.contains(word)) found.insert(word);
  }
  return found;
}

TEST_CASE("Paraphrases: ten or more of every task's instruction", "[labels]") {
  for (const RegistryEntry& entry : registry()) {
    INFO(entry.id);
    const std::string instruction(entry.instruction);
    const std::vector<std::string> texts = paraphrases(instruction);
    CHECK(texts.size() >= 10);
    CHECK(std::set<std::string>(texts.begin(), texts.end()).size() == texts.size());
    CHECK(std::find(texts.begin(), texts.end(), instruction) == texts.end());
    std::set<std::string> allowed = telling_words(instruction);
    allowed.insert("one");  // a pronoun
    if (allowed.contains("cubes")) allowed.insert("cube");
    if (allowed.contains("cup")) allowed.insert("cups");
    if (allowed.contains("battery") || instruction.find("batteries") != std::string::npos) {
      allowed.insert("battery");
    }
    for (const std::string& text : texts) {
      INFO(text);
      CHECK(std::isupper(static_cast<unsigned char>(text.front())) != 0);
      CHECK(text.back() == '.');
      // Nothing is named that the instruction does not name.
      for (const std::string& word : telling_words(text)) {
        INFO(word);
        CHECK(allowed.contains(word));
      }
    }
  }
}

TEST_CASE("Paraphrases: the episode's numbers are in them", "[labels]") {
  const auto batch = test::make_running("RotateStrictPosNeg-VLA-v0",
                                        {.seed = 3, .pins = {{"target_angle", {-0.5}}}});
  const std::vector<std::string> texts = paraphrases(Queries(*batch).instruction(0));
  REQUIRE(texts.size() >= 10);
  for (const std::string& text : texts) {
    CHECK_THAT(text, Catch::Contains("-29 degrees") && !Catch::Contains("{"));
  }
  for (const std::string& text : paraphrases(
           "When the white lamp turns green, start counting steps from that exact moment. Move the "
           "blue cube from the green disc to the red disc exactly on step 77 of that count.")) {
    CHECK_THAT(text, Catch::Contains("77"));
  }
  for (const std::string& text :
       paraphrases("Rotate the peg by {angle_deg} degrees to match the target angle.")) {
    CHECK_THAT(text, Catch::Contains("{angle_deg}"));
  }
}

TEST_CASE("Paraphrases: none of other sentences", "[labels]") {
  CHECK(paraphrases("Do something else.").empty());
  CHECK(paraphrases("").empty());
  CHECK(paraphrases("Rotate the peg by some degrees to match the target angle.").empty());
  CHECK(paraphrases("Rotate the peg by - degrees to match the target angle.").empty());
  CHECK(paraphrases("Rotate the peg by 30 degrees to match the target angle. Now!").empty());
}

}  // namespace
}  // namespace engram
