// Words that the project does not use, because nobody would search for them, and those to use
// instead. Names in code count: words end at underscores and at capitals.
#include <catch2/catch.hpp>
#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include "tests/conventions/sources.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

struct BannedWord {
  const char* word;  // pattern, lower case
  const char* instead;
};

// docs/glossary.md has the project's own terms beside the field's.
const BannedWord kBanned[] = {
    {"sieve[ds]?", "broad phase; filter"},
    {"wakers?", "sleep manager"},
    {"workbench(es)?", "workspace"},
    {"glide[rsd]?|gliders|gliding", "kinematic motion"},
    {"fore(see|sees|seen|sight)", "speculative contact; predict"},
    {"harvest(s|ed)?", "read back"},
    {"engulf(s|ed)?", "deeply penetrating"},
    {"movers?", "dynamic body"},
    {"kin", "and the like"},
    {"mend(s|ed|ing)?", "fix"},
    {"be it", "whether"},
    {"doors?", "API, binding"},
    {"houses?", "project, module"},
    {"whose rules", "rule set"},
    {"haste", "action cost"},
    {"k (most|least)", "kMax, kMin"},
    {"so many", "a number or its name"},
    {"somebody", "caller, user"},
    {"deeds?", "skill, subtask"},
    {"hurr(y|ies|ied)", "shorten"},
    {"strangers?", "unauthenticated client"},
    {"seed seals?", "seed commitment"},
    {"past choosers?", "counterfactual"},
    {"no twins", "no counterfactuals"},
    {"batch rules", "batch task"},
    {"external tasks?", "custom task"},
    {"output turns?", "output buffer"},
    {"require drained", "check for pending replies"},
    {"overlap share|anchor share", "Baumgarte factor"},
    {"describe rows", "describe state fields"},
    {"step by rules", "batch task"},
    {"await choices", "answer controller"},
    {"conclude[ds]?", "set the outcome; end"},
    {"present of", "counterfactual"},
    {"stand(s|ing)? around", "scenery"},
    {"live[ds]? to see", "bootstrapped value"},
};

// Splits names: "glideStep" and "glide_step" hold "glide".
std::string words_of(const std::string& line) {
  std::string words;
  bool lower = false;
  for (const char c : line) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isupper(byte) != 0 && lower) words += ' ';
    lower = std::islower(byte) != 0;
    words += c == '_' ? ' ' : static_cast<char>(std::tolower(byte));
  }
  return words;
}

std::string banned_word_in(const std::string& line) {
  static const std::regex any = [] {
    std::string all;
    for (const BannedWord& banned : kBanned) {
      all += (all.empty() ? "\\b(" : "|") + std::string(banned.word);
    }
    return std::regex(all + ")\\b");
  }();
  std::smatch match;
  const std::string words = words_of(line);
  return std::regex_search(words, match, any) ? match.str() : "";
}

std::string instead_of(const std::string& word) {
  for (const BannedWord& banned : kBanned) {
    if (std::regex_match(word, std::regex(banned.word))) return banned.instead;
  }
  return "";
}

// Texts that name such words on purpose, and instructions, which are part of a task's bits.
bool is_exempt(const fs::path& file) {
  for (const char* path :
       {"tests/conventions/vocabulary_test.cc", "docs/glossary.md",
        "tests/data/original_pictures.json", "tasks/common/procedure_paraphrases.cc"}) {
    if (file == path) return true;
  }
  return false;
}

TEST_CASE("Names, comments and pages use the field's words", "[conventions]") {
  for (const char* folder : {"core", "mjcf", "tasks", "render", "media", "protocol", "api", "apps",
                             "bench", "python", "tests", "scripts", "tools", "cmake", "docs"}) {
    DYNAMIC_SECTION(folder) {
      const auto files = test::files_in(
          folder, {".h", ".cc", ".c", ".py", ".sh", ".cmake", ".md", ".toml", ".js", ".html"});
      CHECK_FALSE(files.empty());
      for (const fs::path& file : files) {
        if (is_exempt(file)) continue;
        int number = 0;
        for (const std::string& line : test::lines_of(test::kRoot / file)) {
          ++number;
          const std::string word = banned_word_in(line);
          if (word.empty()) continue;
          FAIL_CHECK(file.string()
                     << ":" << number << ": '" << word << "'; use " << instead_of(word));
        }
      }
    }
  }
}

TEST_CASE("Banned words are found", "[conventions]") {
  CHECK(banned_word_in("void glide_prop(int env);") == "glide");
  CHECK(banned_word_in("class PairSieve {") == "sieve");
  CHECK(banned_word_in("// A mended file") == "mended");
  CHECK(banned_word_in("be it too early") == "be it");
  CHECK(banned_word_in("constexpr int kMostLanes = 8;") == "k most");
  CHECK(banned_word_in("// The kernel of so many lanes") == "so many");
  CHECK(banned_word_in("recommended, kinematic, indoors, warehouse").empty());
  CHECK(instead_of("doors") == "API, binding");
}

}  // namespace
}  // namespace engram
