#include "protocol/io/json_checksum.h"

#include <catch2/catch.hpp>

namespace engram {

TEST_CASE("A checksum has 16 digits and changes with the document", "[document]") {
  const std::string one = document_checksum({{"a", 1}});
  CHECK(one.size() == 16);
  CHECK(one == document_checksum({{"a", 1}}));
  CHECK(one != document_checksum({{"a", 2}}));
  CHECK(one != document_checksum({{"b", 1}}));
}

TEST_CASE("A checksum is at the end of its document", "[document]") {
  JsonTable document = {{"a", 1}};
  CHECK_FALSE(has_valid_checksum(document));
  add_checksum(document);
  CHECK(has_valid_checksum(document));
  CHECK(has_valid_checksum(*parse_json(to_text(document))));
  document.front().second = 2;
  CHECK_FALSE(has_valid_checksum(document));
  CHECK_FALSE(has_valid_checksum(Json()));
  CHECK_FALSE(has_valid_checksum(JsonTable()));
}

}  // namespace engram
