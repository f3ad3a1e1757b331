#include "core/base/error.h"

#include <catch2/catch.hpp>
#include <string>

namespace engram {
namespace {

TEST_CASE("Error carries its kind and message", "[error]") {
  try {
    throw Error(Error::kUnknownId, "no task 'X'");
  } catch (const std::runtime_error& caught) {
    CHECK(std::string(caught.what()) == "no task 'X'");
    const auto* error = dynamic_cast<const Error*>(&caught);
    REQUIRE(error != nullptr);
    CHECK(error->kind() == Error::Kind::kUnknownId);
  }
}

TEST_CASE("A wrong length is an invalid argument, with both numbers in the message", "[error]") {
  CHECK_NOTHROW(require_length("seeds", 4, 4));
  CHECK_THROWS_WITH(require_length("seeds", 3, 4), "seeds: 3 values given, 4 needed");
  try {
    require_length("seeds", 3, 4);
  } catch (const Error& error) {
    CHECK(error.kind() == Error::kInvalidArgument);
  }
}

}  // namespace
}  // namespace engram
