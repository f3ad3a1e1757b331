#include "protocol/io/html.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

namespace engram {
namespace {

TEST_CASE("Reports escape their texts", "[html]") {
  HtmlReport report("<title>");
  report.paragraph("a & b");
  report.table({"<x>"}, {{"\"quoted\""}});
  const std::string text = report.text();
  CHECK_THAT(text, Catch::Contains("&lt;title&gt;") && Catch::Contains("a &amp; b") &&
                       Catch::Contains("&lt;x&gt;") && Catch::Contains("&quot;quoted&quot;"));
  CHECK_THAT(text, !Catch::Contains("<title><title>"));
}

TEST_CASE("Numbers in tables are aligned to the right", "[html]") {
  HtmlReport report("numbers");
  report.table({"task", "rate"}, {{"a task", "0.125"}});
  CHECK_THAT(report.text(), Catch::Contains("<td>a task</td><td class=\"number\">0.125</td>"));
}

TEST_CASE("Images are embedded", "[html]") {
  const std::byte bytes[] = {std::byte{'M'}, std::byte{'a'}, std::byte{'n'}, std::byte{'!'}};
  HtmlReport report("picture");
  report.image("caption", bytes);
  CHECK_THAT(report.text(),
             Catch::Contains("data:image/png;base64,TWFuIQ==") && Catch::Contains("caption"));
}

TEST_CASE("Curves have points, intervals, a name and the quantity", "[html]") {
  HtmlReport report("curves");
  report.curves({{"success <1>", {{0, 1, 0.5, 1}, {9, 0.25, 0, 0.5}}}},
                {"steps & more", true, 0.5});
  const std::string text = report.text();
  CHECK_THAT(text, Catch::Contains("success &lt;1&gt;") && Catch::Contains("steps &amp; more") &&
                       Catch::Contains("<polyline points=\"40.0,10.0 540.0,152.5 \""));
}

TEST_CASE("Bars have labels, values and a mark", "[html]") {
  HtmlReport report("bars");
  report.bars({{"first", 0.25, 0.5, "group", 0.125, 0.375}, {"second", 1, -1, "other"}});
  const std::string text = report.text();
  CHECK_THAT(text, Catch::Contains("first") && Catch::Contains("width:25.0%") &&
                       Catch::Contains("<u style=\"left:12.5%;width:25.0%\">") &&
                       Catch::Contains("left:50.0%") && Catch::Contains("0.250") &&
                       Catch::Contains("second"));
  CHECK(text.find("left:", text.find("second")) == std::string::npos);  // no mark
}

TEST_CASE("Reports fit narrow screens and dark ones", "[html]") {
  HtmlReport report("wide");
  report.table({"task", "rate"}, {{"a task", "0.125"}});
  CHECK_THAT(report.text(), Catch::Contains("width=device-width") &&
                                Catch::Contains("prefers-color-scheme: dark") &&
                                Catch::Contains("<div class=\"scroll\" tabindex=\"0\"><table>"));
}

TEST_CASE("Counts of one have no plural", "[html]") {
  CHECK(counted(1, "task") == "1 task");
  CHECK(counted(0, "task") == "0 tasks");
  CHECK(counted(2, "task") == "2 tasks");
}

}  // namespace
}  // namespace engram
