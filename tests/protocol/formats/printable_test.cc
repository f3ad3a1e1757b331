#include "protocol/formats/printable.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

using std::string_literals::operator""s;

TEST_CASE("Control characters are shown, not obeyed", "[printable]") {
  CHECK(printable("RememberColor3-VLA-v0") == "RememberColor3-VLA-v0");
  CHECK(printable("\x1b]0;title\x07") == "\\u001b]0;title\\u0007");
  CHECK(printable("a\0b"s) == "a\\u0000b");
  CHECK(printable("\x7f") == "\\u007f");
  CHECK(printable("\xc2\x9b"
                  "31m") == "\\u009b31m");  // the other form of ESC [
  CHECK(printable("a\nb\tc\r") == "a\\u000ab\\u0009c\\u000d");
  CHECK(printable("a\nb\tc\r", true) == "a\nb\tc\\u000d");
}

TEST_CASE("Other letters are as they were", "[printable]") {
  for (const char* text : {"Gr\xc3\xbc\xc3\x9f", "\xc2\xa0", "\xe2\x82\xac", "\xff\xfe", "\xc2"}) {
    CHECK(printable(text) == text);
  }
}

}  // namespace
}  // namespace engram
