#include "tasks/gather_and_recall/expert.h"

#include <algorithm>
#include <cmath>

#include "tasks/common/grasp_servo.h"
#include "tasks/common/guess_stream.h"
#include "tasks/common/poses.h"
#include "tasks/common/press_servo.h"
#include "tasks/common/words.h"

namespace engram::tasks {
namespace {

constexpr double kTableHeight = 0.05;     // m, of the TCP: where the tool is slowest
constexpr double kTravelHeight = 0.13;    // m: a cube in the hand passes over all others
constexpr double kClearance = 0.06;       // m above a cube that was released
constexpr double kFingersClear = 0.035;   // m above a cube: the fingers no longer reach it
constexpr double kLowTravelHeight = 0.1;  // m: enough to clear a cube that was dropped
constexpr double kNearButtons = 0.07;     // m: how much nearer to the buttons a single cube goes
constexpr double kNearRim = 0.03;         // m
constexpr double kOpening = 0.44;         // 26 mm per finger: clear of the neighbours
constexpr Tilt kTilt{.reach = 0.77, .per_metre = 4.0, .most = 0.12};

Eigen::Vector3d place_of(int cube, const Vec2& disc) {
  const Vec2 place = disc + place_on_disc(cube);
  return {place.x(), place.y(), kOnDisc};
}

bool has_landed(const Eigen::Vector3d& cube, const Vec2& disc, double threshold) {
  constexpr double kRim = 0.005;  // m
  const Eigen::Vector3d offset = cube - Eigen::Vector3d(disc.x(), disc.y(), kOnDisc);
  return offset.head<2>().norm() < threshold - kRim && std::abs(offset.z()) < kRim;
}

// Tests that the fingers are beside or above a cube; others may stand close by.
bool is_around(const State& state, int env, int cube) {
  constexpr double kBetweenFingers = 0.02;  // m
  const Eigen::Vector3d offset = prop_pos(state, env, cube) - tcp_pos(state, env);
  return offset.head<2>().norm() <= kBetweenFingers;
}

// Releases only a cube between the fingers.
bool release_cube(const State& state, int env, const Grip& grip, float* action) {
  if (!is_around(state, env, grip.prop)) return true;
  return release(state, env, grip, kClearance, action);
}

}  // namespace

void GatherExpert::act(Range envs, Script script, FloatRows actions) const {
  for (int env = envs.begin; env < envs.end; ++env) {
    float* action = actions.row(env);
    if (script == Script::kSweep) {
      sweep(env, action);
    } else {
      const int color = script == Script::kBlind ? guess(env) : view_.flash_color[env];
      gather_and_press(env, color, action);
    }
  }
}

void GatherExpert::gather_and_press(int env, int color, float* action) const {
  const State& state = *view_.engine.state;
  if (bring_cubes(env, disc(env), action)) {
    if (view_.pressed_button[env] >= 0 || awaits_choice(env)) {
      hold_tcp(kGripperClosed, action);
    } else {
      press(env, color, action);
    }
  }
  limit_speed_near(state, env, kTableHeight, action);
}

// Without memory: presses the button of the colour that the lamp shows now; after that the nearest
// one.
void GatherExpert::sweep(int env, float* action) const {
  const int shown = view_.flash_active[env] != 0 ? view_.flash_color[env] : -1;
  if (shown >= 0 && all_over_disc(env)) {
    drop_and_press(env, shown, action);
    return;
  }
  // A single cube lights the lamp itself: near the buttons there is time to follow the lamp.
  const double threshold = view_.params.DISC_ON_THRESH;
  const double nearer =
      view_.params.N_CUBES == 1 ? std::clamp(threshold - kNearRim, 0.0, kNearButtons) : 0.0;
  if (bring_cubes(env, disc(env) - Vec2(nearer, 0), action)) {
    press(env, nearest_button(env), action);
  }
  limit_speed_near(*view_.engine.state, env, kTableHeight, action);
}

bool GatherExpert::bring_cubes(int env, const Vec2& center, float* action) const {
  const State& state = *view_.engine.state;
  for (int cube = 0; cube < view_.params.N_CUBES; ++cube) {
    const Eigen::Vector3d place = place_of(cube, center);
    const Eigen::Vector3d pos = prop_pos(state, env, cube);
    Grip grip{.prop = cube, .opening = kOpening, .travel_height = kTravelHeight};
    if (!is_held(state, env, cube)) {
      grip.tool = tilt_outwards(cube_grasp_orientation(state, env, cube), pos, kTilt);
      if (has_landed(pos, center, view_.params.DISC_ON_THRESH)) {
        if (!release_cube(state, env, grip, action)) return false;
        continue;
      }
    } else {
      grip.tool = tilt_outwards(kToolDown, place, kTilt);
    }
    if (!pick_and_place(state, env, grip, place, action)) return false;
  }
  return true;
}

void GatherExpert::press(int env, int color, float* action) const {
  const State& state = *view_.engine.state;
  const Eigen::Vector3d waypoint = press_waypoint(button(color), env, kTravelHeight);
  servo_tcp(state, env, transfer_waypoint(state, env, waypoint, kTravelHeight), kToolDown,
            kGripperClosed, action);
}

void GatherExpert::drop_and_press(int env, int color, float* action) const {
  const State& state = *view_.engine.state;
  for (int cube = 0; cube < view_.params.N_CUBES; ++cube) {
    if (is_grasping(state, env, cube)) {
      hold_tcp(kGripperOpen, action);
      return;
    }
    const Eigen::Vector3d tcp = tcp_pos(state, env);
    const double clear = prop_pos(state, env, cube).z() + kFingersClear;
    if (is_around(state, env, cube) && tcp.z() < clear) {
      servo_tcp(state, env, {tcp.x(), tcp.y(), kLowTravelHeight}, kToolDown, kGripperOpen, action);
      return;
    }
  }
  servo_tcp(state, env, press_waypoint(button(color), env, kLowTravelHeight), kToolDown,
            kGripperOpen, action);
}

bool GatherExpert::all_over_disc(int env) const {
  for (int cube = 0; cube < view_.params.N_CUBES; ++cube) {
    const Vec2 at = prop_pos(*view_.engine.state, env, cube).head<2>();
    if ((at - disc(env)).norm() >= view_.params.DISC_ON_THRESH) return false;
  }
  return true;
}

int GatherExpert::nearest_button(int env) const {
  const auto distance = [env](const PressButton& button) { return button.distance(env); };
  return static_cast<int>(std::ranges::min_element(view_.buttons, {}, distance) -
                          view_.buttons.begin());
}

// Button that an agent without memory would press, or that the caller has chosen.
int GatherExpert::guess(int env) const {
  return choice_or(env, [&] { return guess_stream(view_.engine, env).integer(0, kColors - 1); });
}

ChoiceForm GatherExpert::choice_form() const {
  ChoiceForm form{.question = "Which button is to be pressed?"};
  for (const mjcf::Rgba& color : FLASH_COLORS) {
    form.items.push_back("the " + name_color(color) + " button");
  }
  return form;
}

// The cubes are on the disc, the tool is clear of them, and the flash is over.
bool GatherExpert::is_choice_due(int env) const {
  if (!awaits_choice(env) || view_.flash_triggered[env] == 0 || view_.flash_active[env] != 0) {
    return false;
  }
  constexpr std::size_t kActionDim = 7;
  std::array<float, kActionDim> unused{};
  return bring_cubes(env, disc(env), unused.data());
}

}  // namespace engram::tasks
