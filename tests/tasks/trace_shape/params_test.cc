#include "tasks/trace_shape/params.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

TEST_CASE("Corners and nearest points are those of the available shapes", "[trace]") {
  tasks::TraceParams params = tasks::kTraceVariants[0];  // circles
  CHECK(params.farthest_corner() == Approx(params.SHAPE_RADIUS_RANGE.high));
  CHECK(params.nearest_point() == Approx(params.SHAPE_RADIUS_RANGE.low));
  params.AVAILABLE_SHAPES = tasks::NameList(2);  // and squares
  CHECK(params.farthest_corner() > 1.3 * params.SHAPE_RADIUS_RANGE.high);
}

TEST_CASE("Contradictory constants are refused", "[trace]") {
  tasks::TraceParams params = tasks::kTraceSeqVariants[0];
  CHECK_NOTHROW(params.check(1500));
  params.MIN_SEQUENCE_LENGTH = 6;
  CHECK_THROWS_WITH(params.check(1500), Catch::Contains("at most MAX_SEQUENCE_LENGTH 5 allowed"));
  params.MIN_SEQUENCE_LENGTH = 2;
  params.contours.NUM_WAYPOINTS = 10;
  CHECK_THROWS_WITH(params.check(1500), Catch::Contains("at most NUM_WAYPOINTS 10 allowed"));
}

}  // namespace
}  // namespace engram
