#include "core/base/join.h"

#include <array>
#include <catch2/catch.hpp>
#include <vector>

namespace engram {
namespace {

struct Named {
  std::string name;
};

TEST_CASE("Texts are joined with commas", "[join]") {
  CHECK(join(std::vector<std::string>{}).empty());
  CHECK(join(std::vector<std::string>{"one"}) == "one");
  CHECK(join(std::array<std::string_view, 3>{"a", "b", "c"}) == "a, b, c");
  CHECK(join(std::vector<const char*>{"", "x", ""}) == ", x, ");
}

TEST_CASE("Items are joined by a member or a function, with any separator", "[join]") {
  const std::vector<Named> items = {{"a"}, {"b"}};
  CHECK(join(items, &Named::name) == "a, b");
  CHECK(join(items, &Named::name, "|") == "a|b");
  CHECK(join(
            std::vector<int>{2, 30}, [](int n) { return std::to_string(n); }, "") == "230");
}

TEST_CASE("Numbers are as short as can be, whole ones without an exponent", "[join]") {
  CHECK(shortest(7) == "7");
  CHECK(shortest(-1e9) == "-1000000000");
  CHECK(shortest(123456789012) == "123456789012");
  CHECK(shortest(0.1) == "0.1");
  CHECK(shortest(1e300) == "1e+300");
}

}  // namespace
}  // namespace engram
