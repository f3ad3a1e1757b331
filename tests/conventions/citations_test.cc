// What comments and pages refer to is there.
#include <catch2/catch.hpp>
#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include "core/base/join.h"
#include "tests/conventions/sources.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

// "." stands for the root itself, without its folders.
const char* const kFolders[] = {"core",  "mjcf",  "tasks", "render", "media", "protocol",
                                "api",   "apps",  "bench", "python", "tests", "scripts",
                                "tools", "cmake", "docs",  "."};

std::vector<fs::path> texts_in(std::string_view folder) {
  if (folder == ".") {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(test::kRoot)) {
      const fs::path file = entry.path().filename();
      if (file.extension() == ".md" || file.extension() == ".txt") files.push_back(file);
    }
    return files;
  }
  return test::files_in(folder,
                        {".h", ".cc", ".c", ".py", ".sh", ".cmake", ".md", ".txt", ".toml"});
}

// Calls f(file, line) for every line of a folder's texts.
template <class F>
void for_each_line(std::string_view folder, F&& f) {
  const std::vector<fs::path> files = texts_in(folder);
  CHECK_FALSE(files.empty());
  for (const fs::path& file : files) {
    for (const std::string& line : test::lines_of(test::kRoot / file)) f(file, line);
  }
}

// Pages that a line names and that are not there: "docs/page.md" from the root, and in pages the
// targets of links from where they lie.
std::vector<std::string> missing_pages(const std::string& line, const fs::path& file) {
  static const std::regex page(R"(docs/[A-Za-z0-9_./-]*\.md)");
  static const std::regex link(R"(\]\(([^)#: ]+\.md))");
  std::vector<std::string> missing;
  const auto look = [&](const std::regex& pattern, std::size_t group, const fs::path& from) {
    for (std::sregex_iterator at(line.begin(), line.end(), pattern), end; at != end; ++at) {
      if (!fs::exists(from / (*at)[group].str())) missing.push_back((*at)[group]);
    }
  };
  if (line.find(".md") == std::string::npos) return missing;
  look(page, 0, test::kRoot);
  if (file.extension() == ".md") look(link, 1, test::kRoot / file.parent_path());
  return missing;
}

// The part of a line that people read: all of a page, a comment elsewhere; Python's whole line,
// because it may be of a docstring.
std::string comment_of(const std::string& line, const fs::path& file) {
  const std::string extension = file.extension().string();
  if (extension == ".md" || extension == ".py") return line;
  const bool hash =
      extension == ".sh" || extension == ".cmake" || extension == ".toml" || extension == ".txt";
  std::size_t at = line.find(hash ? "#" : "//");
  if (!hash && at == std::string::npos) {
    at = line.find("/*");
    const std::size_t first = line.find_first_not_of(' ');
    if (at == std::string::npos && first != std::string::npos && line[first] == '*') at = first;
  }
  return at == std::string::npos ? "" : line.substr(at);
}

// Sections of a text that is not part of this project, such as "(common 5.3)".
bool cites_sections(const std::string& comment) {
  static const std::string chapter = "(common|shell|remember|procedural|buttons|intercept|design)";
  // With a point, it is a measure if a unit comes behind it; without, a number of things if any
  // word does.
  static const std::regex cited("\\b" + chapter +
                                " (\\d+\\.\\d+(\\.\\d+)*(?!\\d| ?(m|mm|cm|rad|s|kg|N)\\b| ?%)|"
                                "\\d+(?=[),;:]|\\.?$|\\.? *\\*/|\\. | (and|to|or) \\d))|"
                                "\\b[Ss]ections? \\d");
  const bool digits = comment.find_first_of("0123456789") != std::string::npos;
  return digits && std::regex_search(comment, cited);
}

TEST_CASE("Every page that is named exists", "[conventions]") {
  for (const char* folder : kFolders) {
    DYNAMIC_SECTION(folder) {
      for_each_line(folder, [](const fs::path& file, const std::string& line) {
        if (file.filename() == "citations_test.cc") return;
        const std::vector<std::string> missing = missing_pages(line, file);
        if (!missing.empty()) FAIL_CHECK(file.string() << " names " << join(missing));
      });
    }
  }
}

TEST_CASE("No comment cites sections of a text that is not here", "[conventions]") {
  for (const char* folder : kFolders) {
    DYNAMIC_SECTION(folder) {
      for_each_line(folder, [](const fs::path& file, const std::string& line) {
        if (file.filename() == "citations_test.cc") return;
        if (cites_sections(comment_of(line, file))) FAIL_CHECK(file.string() << ": " << line);
      });
    }
  }
}

TEST_CASE("Citations are found", "[conventions]") {
  for (const char* comment :
       {"The step contract (common 5.3).", "// --- sampling (remember 6) ---", "shell 8.2",
        "// remember 9", "// shell 3, 4", "of procedural 0.9, as", "sections 3.5 and 4.2",
        "Section 12", "(buttons 3.2; shell 1)", "design 4", "(shell 2 to 4)", "of common 9.",
        "/* See common 4 */", "the table of intercept 1.3 has"}) {
    INFO(comment);
    CHECK(cites_sections(comment));
  }
  for (const char* comment : {"// three cubes to remember 9 steps long", "two buttons 0.15 m apart",
                              "docs/tasks/remember.md", "RememberColor9", "have in common",
                              "by design, 4 of them", "intersections 3", "RememberColor 3)"}) {
    INFO(comment);
    CHECK_FALSE(cites_sections(comment));
  }
  CHECK(comment_of("x = 1;  // common 4", "a.cc") == "// common 4");
  CHECK(comment_of(" * common 4", "a.h") == "* common 4");
  CHECK(comment_of("common 4", "a.cc").empty());
  CHECK(comment_of("run  # common 4", "a.sh") == "# common 4");
}

TEST_CASE("Missing pages are found", "[conventions]") {
  const std::string gone =
      "docs/no_such"
      "_page.md";
  CHECK(missing_pages("// (" + gone + " has it)", "a.cc") == std::vector<std::string>{gone});
  CHECK(missing_pages("// docs/evaluation.md", "a.cc").empty());
  CHECK(missing_pages("[one](evaluation.md) [two](no_such.md#x)", "docs/a.md") ==
        std::vector<std::string>{"no_such.md"});
  CHECK(missing_pages("[up](../README.md) [out](https://example.org/a.md)", "docs/a.md").empty());
}

}  // namespace
}  // namespace engram
