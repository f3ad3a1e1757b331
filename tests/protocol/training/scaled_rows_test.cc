#include "protocol/training/scaled_rows.h"

#include <array>
#include <catch2/catch.hpp>
#include <string>

namespace engram::training {
namespace {

RangedField field(const char* name, int width, const char* unit) {
  RangedField made;
  made.field.name = name;
  made.field.width = width;
  made.field.unit = unit;
  return made;
}

TEST_CASE("Positions are vectors from the TCP with a flag", "[training]") {
  const std::vector<RangedField> fields = {field("tcp_pose", 7, "m"), field("cube_pose", 7, "m"),
                                           field("tcp_to_ball_pos", 3, "m"),
                                           field("elapsed", 1, "control steps")};
  const StateRows rows(fields, 20);
  REQUIRE(rows.dim() == 7 + 8 + 4 + 1);
  std::array<float, 18> row = {0.1F, 0, 0.3F, 1, 0, 0, 0,     0.2F, 0,
                               0.3F, 0, 1,    0, 0, 0, 0.05F, 0,    5};
  std::array<float, 20> out{};
  rows.write(row.data(), out.data());
  CHECK(out[0] == Approx(1.707));
  CHECK(out[7] == Approx(1));      // 0.1 m from the TCP
  CHECK(out[11] == 1);             // quaternion
  CHECK(out[14] == 1);             // it is there
  CHECK(out[16] == Approx(0.5));   // a difference already
  CHECK(out[19] == Approx(0.25));  // of the horizon

  row[9] = 1000;  // where hidden things are
  row[7] = 3;
  rows.write(row.data(), out.data());
  for (std::size_t i = 7; i < 15; ++i) CHECK(out[i] == 0);
  row[9] = 0;
  rows.write(row.data(), out.data());
  CHECK(out[7] == 10);  // the limit
}

TEST_CASE("One of several goals counts", "[training]") {
  const std::vector<RangedField> fields = {field("tcp_pose", 7, "m"), field("goal_0_pose", 3, "m"),
                                           field("goal_1_pose", 3, "m"),
                                           field("goal_region", 1, "")};
  const StateRows rows(fields, 20);
  REQUIRE(rows.dim() == 7 + 1 + 4);
  std::array<float, 14> row{};
  std::array<float, 12> out{};
  rows.write(row.data(), out.data());
  CHECK(out[11] == 0);
  row[11] = 0.2F;
  rows.write(row.data(), out.data());
  CHECK(out[9] == Approx(2));
  CHECK(out[11] == 1);
}

}  // namespace
}  // namespace engram::training
