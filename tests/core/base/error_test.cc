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

}  // namespace
}  // namespace engram
