#include "protocol/make/task_description.h"

#include <catch2/catch.hpp>

#include "tasks/family_samples.h"

namespace engram {
namespace {

TEST_CASE("A list entry is a part of the task's description", "[describe]") {
  for (const std::string& id : one_of_each_family()) {
    const Json description = describe_task(*make(id));
    const ConstantTable entry = describe_entry(require_entry(id));
    CHECK(entry.size() == 10);
    for (const auto& [key, value] : entry) {
      INFO(id << ": " << key);
      CHECK((part(description, key) == value));
    }
  }
}

}  // namespace
}  // namespace engram
