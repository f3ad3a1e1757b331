// Comments stand alone: none opens by leaning on the one before it.
#include <catch2/catch.hpp>
#include <filesystem>
#include <regex>
#include <string>

#include "tests/conventions/sources.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

// Text of a line that is a comment or begins a docstring; empty for other lines.
std::string comment_of(const std::string& line) {
  static const std::regex comment(R"(^\s*(///?<?|#|r?""")\s*(.*)$)");
  std::smatch match;
  return std::regex_match(line, match, comment) ? match.str(2) : "";
}

bool leans_on_another(const std::string& comment) {
  static const std::regex openings(
      R"(^(The same|As (that|those) of|Th(at|ose) of|Of|Likewise)\b.*)");
  return std::regex_match(comment, openings);
}

TEST_CASE("Comments open with a sentence of their own", "[conventions]") {
  for (const char* folder : {"core", "mjcf", "tasks", "render", "media", "protocol", "api", "apps",
                             "bench", "python", "tests", "scripts", "tools"}) {
    DYNAMIC_SECTION(folder) {
      for (const fs::path& file : test::files_in(folder, {".h", ".cc", ".c", ".py"})) {
        std::string before;
        int number = 0;
        for (const std::string& line : test::lines_of(test::kRoot / file)) {
          ++number;
          const std::string comment = comment_of(line);
          // Lines that continue a block may begin with any word.
          if (before.empty() && leans_on_another(comment)) {
            FAIL_CHECK(file.string() << ":" << number << ": '" << comment << "'");
          }
          before = comment;
        }
      }
    }
  }
}

TEST_CASE("Comments that lean on others are found", "[conventions]") {
  CHECK(leans_on_another(comment_of("  // The same for a range.")));
  CHECK(leans_on_another(comment_of("  /// Those of one environment.")));
  CHECK(leans_on_another(comment_of(R"(    """Of every step: words.""")")));
  CHECK_FALSE(leans_on_another(comment_of("// Offsets of rows.")));
  CHECK_FALSE(leans_on_another(comment_of("int x = 0;  // of the row")));
}

}  // namespace
}  // namespace engram
