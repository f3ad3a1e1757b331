#include "core/batch/batch_outputs.h"

#include <catch2/catch.hpp>
#include <string>

#include "core/base/error.h"

namespace engram {
namespace {

RangedField field(const char* name, int width) {
  return {{name, width, DType::kFloat32, "", ""}, -1, 1, {}};
}

TEST_CASE("Fields of one name have one place, and new ones come behind their neighbours") {
  const std::vector<std::vector<RangedField>> rows = {
      {field("qpos", 9), field("object_0_seen", 1), field("object_0_kind", 9)},
      {field("qpos", 9), field("task_cue", 2), field("object_0_seen", 1), field("object_0_kind", 9),
       field("object_1_seen", 1)},
      {field("qpos", 9), field("task_cue", 3)}};
  const std::vector<RangedField> common = merged_rows(rows);
  std::string order;
  for (const RangedField& one : common) order += one.field.name + " ";
  CHECK(order == "qpos task_cue object_0_seen object_0_kind object_1_seen ");
  CHECK(offset_of("qpos", common) == 0);
  CHECK(offset_of("object_0_seen", common) == 12);  // behind the widest task_cue
  CHECK(row_width(common) == 9 + 3 + 1 + 9 + 1);
  CHECK(count_tokens(common) == 2);
  CHECK_THROWS_AS(offset_of("goal", common), Error);
}

TEST_CASE("A layout of one task is its own row") {
  const std::vector<std::vector<RangedField>> rows = {{field("qpos", 9), field("goal", 3)}};
  const std::vector<RangedField> common = merged_rows(rows);
  CHECK(row_width(common) == 12);
  CHECK(offset_of("goal", common) == 9);
  CHECK(count_tokens(common) == 0);
}

}  // namespace
}  // namespace engram
