// The press button: depth, and the press, release and lift machine.
#include "tasks/common/press_button.h"

#include <catch2/catch.hpp>
#include <vector>

namespace engram::tasks {
namespace {

constexpr PressButtonParams kButton;

// A tool over the middle of a button, height after height.
struct Tool {
  PressState press;
  int began = 0;
  int confirmed = 0;
  int released = 0;

  PressEvents at(double height, double distance = 0, bool acting = true, bool enabled = true) {
    const double depth = acting ? press_depth(kButton, distance, height) : 0;
    const PressEvents events = press_and_lift(kButton, depth, height, acting, enabled, press);
    began += events.pressed ? 1 : 0;
    confirmed += events.confirmed ? 1 : 0;
    released += events.released ? 1 : 0;
    return events;
  }
};

TEST_CASE("The depth of a press follows the tool", "[button]") {
  CHECK(kButton.shape.top_height() == Approx(0.058));
  CHECK(kButton.shape.cap_height() == Approx(0.044));
  CHECK(press_depth(kButton, 0, 0.3) == 0);
  CHECK(press_depth(kButton, 0, 0.0881) == 0);
  CHECK(press_depth(kButton, 0, 0.084) == Approx(0.004));
  CHECK(press_depth(kButton, 0, 0.080) == Approx(0.008));
  CHECK(press_depth(kButton, 0, 0.074) == Approx(0.014));
  CHECK(press_depth(kButton, 0, 0.01) == 0.014);
  // The circle: strict, or not, as the family has it.
  CHECK(press_depth(kButton, 0.0649, 0.08) > 0);
  CHECK(press_depth(kButton, 0.065, 0.08) == 0);
  PressButtonParams wide = kButton;
  wide.radius_counts = true;
  CHECK(press_depth(wide, 0.065, 0.08) > 0);
  CHECK(press_depth(wide, 0.0651, 0.08) == 0);
}

TEST_CASE("A press takes the worked course", "[button]") {
  struct Row {
    double height;
    bool began, released, confirmed, pending, ready;
  };
  const Row rows[] = {
      {0.100, false, false, false, false, true}, {0.084, false, false, false, false, true},
      {0.080, true, false, false, true, false},  {0.060, false, false, false, true, false},
      {0.084, false, false, false, true, false}, {0.090, false, true, false, true, true},
      {0.070, false, false, false, true, true},  {0.164, false, false, false, true, true},
      {0.166, false, false, true, false, true},
  };
  Tool tool;
  for (const Row& row : rows) {
    INFO("height " << row.height);
    const PressEvents events = tool.at(row.height);
    CHECK(events.pressed == row.began);
    CHECK(events.released == row.released);
    CHECK(events.confirmed == row.confirmed);
    CHECK(tool.press.pending == row.pending);
    CHECK(tool.press.ready == row.ready);
    CHECK(tool.press.start_height == (tool.began > 0 ? 0.080 : 0.0));
  }
}

TEST_CASE("A press without lift takes the worked course", "[button]") {
  struct Row {
    double height;
    bool event, ready;
  };
  const Row rows[] = {{0.3, false, true},    {0.084, false, true},   {0.080, true, false},
                      {0.070, false, false}, {0.0845, false, false}, {0.080, false, false},
                      {0.086, false, true},  {0.080, true, false}};
  PressState press;
  for (const Row& row : rows) {
    INFO("height " << row.height);
    const double depth = press_depth(kButton, 0, row.height);
    CHECK(press_once(kButton, depth, true, true, press) == row.event);
    CHECK(press.ready == row.ready);
  }
}

// A finger that comes down slowly and goes up again, trembling by `swing` around a height on the
// way, however long.
void tremble(Tool& tool, double height, double swing) {
  for (int i = 0; i < 40; ++i) tool.at(height + (i % 2 == 0 ? swing : -swing));
}

void move(Tool& tool, double from, double to) {
  constexpr int kSteps = 200;
  for (int i = 0; i <= kSteps; ++i) tool.at(from + (to - from) * i / kSteps);
}

TEST_CASE("Trembling around a threshold never makes a second press", "[button]") {
  constexpr double kPress = 0.0831;
  constexpr double kRelease = 0.0852;
  // Below the distance of the two thresholds, so that no swing crosses both.
  for (const double swing : {0.0001, 0.0005, 0.001}) {
    INFO("swing " << swing);
    Tool tool;
    move(tool, 0.2, kPress + 0.0011);
    CHECK(tool.began == 0);
    tremble(tool, kPress, swing);  // crosses the press threshold 40 times
    CHECK(tool.began == 1);
    CHECK(tool.released == 0);
    CHECK(tool.confirmed == 0);
    move(tool, kPress, 0.06);
    move(tool, 0.06, kRelease - 0.0011);
    CHECK(tool.released == 0);
    tremble(tool, kRelease, swing);  // and the release threshold
    CHECK(tool.began == 1);
    CHECK(tool.released == 1);
    CHECK(tool.confirmed == 0);
    const double lifted = tool.press.start_height + 0.085;
    move(tool, kRelease, lifted - 0.002);
    CHECK(tool.confirmed == 0);
    tremble(tool, lifted, swing);  // and the height at which the press counts
    CHECK(tool.confirmed == 1);
    move(tool, lifted, 0.3);
    CHECK(tool.began == 1);
    CHECK(tool.released == 1);
    CHECK(tool.confirmed == 1);
  }
}

TEST_CASE("Partial presses do not count", "[button]") {
  Tool shallow;  // turns before the threshold
  for (int i = 0; i < 5; ++i) {
    move(shallow, 0.2, 0.0832);
    tremble(shallow, 0.0842, 0.0009);
    move(shallow, 0.0832, 0.2);
  }
  CHECK(shallow.began == 0);
  CHECK(shallow.confirmed == 0);

  Tool low;  // presses, but is never lifted enough
  move(low, 0.2, 0.06);
  const double start = low.press.start_height;
  for (int i = 0; i < 5; ++i) {
    move(low, 0.06, start + 0.0849);
    move(low, start + 0.0849, 0.06);
  }
  CHECK(low.began == 1);
  CHECK(low.confirmed == 0);
  CHECK(low.press.start_height == start);  // later dips are part of the same press
  move(low, 0.06, start + 0.086);
  CHECK(low.confirmed == 1);

  Tool beside;  // outside the circle
  for (const double height : {0.2, 0.08, 0.06, 0.08, 0.2}) beside.at(height, 0.065);
  CHECK(beside.began == 0);
  CHECK(beside.released == 0);
}

TEST_CASE("Leaving sideways releases, and the lift may happen anywhere", "[button]") {
  Tool tool;
  CHECK(tool.at(0.08).pressed);
  CHECK(tool.at(0.08, 0.07).released);
  CHECK(tool.at(0.166, 0.2).confirmed);
  // Release and confirmation may fall into one evaluation.
  CHECK(tool.at(0.08).pressed);
  const PressEvents both = tool.at(0.17);
  CHECK(both.released);
  CHECK(both.confirmed);
}

TEST_CASE("Phase and gate hold presses back", "[button]") {
  Tool waiting;
  CHECK_FALSE(waiting.at(0.08, 0, false).pressed);
  CHECK(waiting.at(0.08, 0, true).pressed);  // at once when the phase begins
  Tool gated;
  CHECK_FALSE(gated.at(0.08, 0, true, false).pressed);
  CHECK(gated.at(0.08).pressed);
  CHECK(gated.at(0.2, 0, true, false).released);  // the gate does not stop releases
  CHECK(gated.press.pending);                     // nor does it cancel a press: it waits
  CHECK(gated.at(0.2).confirmed);
}

}  // namespace
}  // namespace engram::tasks
