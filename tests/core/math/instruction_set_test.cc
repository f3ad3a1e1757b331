#include "core/math/instruction_set.h"

#include <catch2/catch.hpp>
#include <string>

namespace engram {
namespace {

TEST_CASE("Every processor has the baseline, and what it chooses by itself", "[math]") {
  CHECK(is_available(InstructionSet::kAuto));
  CHECK(is_available(InstructionSet::kBaseline));
}

TEST_CASE("A processor with AVX-512 has AVX2", "[math]") {
  if (is_available(InstructionSet::kAvx512)) CHECK(is_available(InstructionSet::kAvx2));
}

TEST_CASE("Instruction sets go by their names", "[math]") {
  CHECK(name_of(InstructionSet::kAuto) == std::string("auto"));
  CHECK(name_of(InstructionSet::kBaseline) == std::string("baseline"));
  CHECK(name_of(InstructionSet::kAvx2) == std::string("avx2"));
  CHECK(name_of(InstructionSet::kAvx512) == std::string("avx512"));
}

}  // namespace
}  // namespace engram
