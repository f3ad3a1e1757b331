#include "tasks/shell_game/touch_params.h"

#include <algorithm>

#include "core/base/join.h"
#include "tasks/common/phase_budget.h"
#include "tasks/shell_game/mugs.h"

namespace engram::tasks {
namespace {

constexpr int kStepsToTouch = 12;  // control steps

// Fingertips are a centimetre above the foot of a mug that is touched, so that nothing is shoved;
// nearer where GOAL_THRESH asks for it.
constexpr double kTouchGap = 0.074;     // m above the origin of the benchmark's mug
constexpr double kTouchMargin = 0.005;  // m: how much nearer than GOAL_THRESH the tool goes
constexpr double kFingertips = 0.011;   // m that they reach below the TCP

}  // namespace

double TouchParams::touch_gap() const {
  const double above = resting_height() - mjcf::kMugRestingHeight;
  return std::min(kTouchGap + above, GOAL_THRESH - kTouchMargin);
}

void TouchParams::check(int horizon) const {
  check_touch();
  check_horizon(horizon, {{"CUE_PHASE_STEPS", CUE_PHASE_STEPS.high}}, kStepsToTouch);
}

void TouchParams::check_touch() const {
  check_mugs(*this, kUpsideDown);
  const double least = resting_height() + kFingertips + kTouchMargin;
  if (GOAL_THRESH < least) {
    refuse_constant("GOAL_THRESH", shortest(GOAL_THRESH),
                    "at least " + in_millimetres(least) + " allowed: the foot of a cup is " +
                        in_millimetres(resting_height()) + " above its origin, fingertips reach " +
                        in_millimetres(kFingertips) + " below the tool, and " +
                        in_millimetres(kTouchMargin) + " are for the tool to come to rest");
  }
  if (GOAL_THRESH >= MIN_DIST) {
    refuse_constant("GOAL_THRESH", shortest(GOAL_THRESH),
                    "less than MIN_DIST " + shortest(MIN_DIST) +
                        " allowed: a tool over one cup would touch the next");
  }
}

}  // namespace engram::tasks
