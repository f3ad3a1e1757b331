#include "core/observe/object_words.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

TEST_CASE("Shapes have English names", "[objects]") {
  CHECK(shape_word(-1) == "object");
  CHECK(shape_word(0) == "cube");
  CHECK(shape_word(6) == "pyramid");
  CHECK(shape_word(7) == "T shape");
}

TEST_CASE("Lengths are written in metres, to the centimetre", "[objects]") {
  CHECK(in_metres(0) == "0.00 m");
  CHECK(in_metres(-0.004) == "0.00 m");
  CHECK(in_metres(0.05) == "0.05 m");
  CHECK(in_metres(-0.126) == "-0.13 m");
  CHECK(in_metres(12.3) == "12.30 m");
}

}  // namespace
}  // namespace engram
