#include "core/batch/row_layout.h"

#include <catch2/catch.hpp>
#include <string>

#include "core/base/error.h"

namespace engram {
namespace {

RangedField field(const char* name, int width) {
  return {{name, width, DType::kFloat32, "", ""}, -1, 1, {}};
}

TEST_CASE("Fields of one name have one place, and new ones come behind their neighbours") {
  const RowLayout layout({{field("qpos", 9), field("object_0_seen", 1), field("object_0_kind", 9)},
                          {field("qpos", 9), field("task_cue", 2), field("object_0_seen", 1),
                           field("object_0_kind", 9), field("object_1_seen", 1)},
                          {field("qpos", 9), field("task_cue", 3)}});
  std::string order;
  for (const RangedField& one : layout.fields()) order += one.field.name + " ";
  CHECK(order == "qpos task_cue object_0_seen object_0_kind object_1_seen ");
  CHECK(layout.offset_of("qpos") == 0);
  CHECK(layout.offset_of("object_0_seen") == 12);  // behind the widest task_cue
  CHECK(layout.width() == 9 + 3 + 1 + 9 + 1);
  CHECK(count_tokens(layout.fields()) == 2);
  CHECK_THROWS_AS(layout.offset_of("goal"), Error);
}

TEST_CASE("A layout of one task is its own row") {
  const RowLayout layout({{field("qpos", 9), field("goal", 3)}});
  CHECK(layout.width() == 12);
  CHECK(layout.offset_of("goal") == 9);
  CHECK(count_tokens(layout.fields()) == 0);
}

}  // namespace
}  // namespace engram
