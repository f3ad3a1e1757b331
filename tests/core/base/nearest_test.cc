#include "core/base/nearest.h"

#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

namespace engram {
namespace {

TEST_CASE("The edit distance counts insertions, deletions and replacements", "[nearest]") {
  CHECK(edit_distance("", "") == 0);
  CHECK(edit_distance("", "abc") == 3);
  CHECK(edit_distance("abc", "") == 3);
  CHECK(edit_distance("kitten", "sitting") == 3);
  CHECK(edit_distance("Rotate", "rOTATE") == 0);
  CHECK(edit_distance("flaw", "lawn") == edit_distance("lawn", "flaw"));
}

TEST_CASE("The nearest name has the fewest edits, and is the first of several", "[nearest]") {
  const std::vector<std::string> names = {"reset", "render", "step"};
  CHECK(nearest(names, "rest") == "reset");
  CHECK(nearest(names, "STEPS") == "step");
  CHECK(nearest(std::array{"ab", "ac"}, "a") == "ab");
  CHECK(nearest(std::vector<std::string>{}, "anything").empty());
}

TEST_CASE("Names are read from items, and absurdly long input is cut", "[nearest]") {
  struct Item {
    std::string name;
  };
  const std::vector<Item> items = {{"colour"}, {"shape"}};
  CHECK(nearest(items, "color", &Item::name) == "colour");
  CHECK(nearest(items, "shape" + std::string(10'000'000, 'x'), &Item::name) != "");
}

}  // namespace
}  // namespace engram
