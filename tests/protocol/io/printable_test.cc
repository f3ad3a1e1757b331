#include "protocol/io/printable.h"

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

TEST_CASE("Marks that reverse the order of letters are shown, not obeyed", "[printable]") {
  CHECK(printable("a\u202etxt.exe") == "a\\u202etxt.exe");
  CHECK(printable("\u200f\u2066\u2069\u061c\ufeff") == "\\u200f\\u2066\\u2069\\u061c\\ufeff");
  CHECK(printable("a\u2028b", true) == "a\\u2028b");
}

TEST_CASE("Bytes that are not UTF-8 are shown by their numbers", "[printable]") {
  CHECK(printable("\x9b"
                  "31m") == "\\x9b31m");  // ESC [ of terminals with 8 bits
  CHECK(printable("\xff\xfe") == "\\xff\\xfe");
  CHECK(printable("\xc2") == "\\xc2");
  CHECK(printable("\xc0\x9b") == "\\xc0\\x9b");           // a longer form than needed
  CHECK(printable("\xed\xa0\x80") == "\\xed\\xa0\\x80");  // half a pair
  CHECK(printable("\xf4\x90\x80\x80") == "\\xf4\\x90\\x80\\x80");
  CHECK(printable("\xf8\x90\x80\x80") == "\\xf8\\x90\\x80\\x80");
  CHECK(printable("\xe2\x82") == "\\xe2\\x82");
}

TEST_CASE("Other letters are as they were", "[printable]") {
  for (const char* text : {"Gr\xc3\xbc\xc3\x9f", "\xc2\xa0", "\xe2\x82\xac", "\xf0\x9f\x90\x98"}) {
    CHECK(printable(text) == text);
  }
}

}  // namespace
}  // namespace engram
