#include "tasks/gather_and_recall/task.h"

#include <algorithm>
#include <array>
#include <string>

#include "mjcf/disc.h"
#include "mjcf/scene.h"
#include "tasks/gather_and_recall/params.h"
#include "tasks/gather_and_recall/rules.h"
#include "tasks/parts/grasp_servo.h"
#include "tasks/parts/lamp.h"
#include "tasks/parts/phase_clock.h"
#include "tasks/parts/press_button.h"
#include "tasks/parts/reward_dict.h"
#include "tasks/parts/state_row.h"
#include "tasks/parts/task_info.h"

namespace engram::tasks {
namespace {

class GatherAndRecall final : public Task {
 public:
  GatherAndRecall(const RegistryEntry& entry, int cubes)
      : cubes_(cubes),
        scene_(cubes_and_disc(cubes)),
        disc_(cubes),
        buttons_{PressButton(scene_, "button_red", gather_button(0)),
                 PressButton(scene_, "button_green", gather_button(1)),
                 PressButton(scene_, "button_blue", gather_button(2))},
        lamp_(scene_, "lamp") {
    info_ = describe(entry);
    describe_gather(cubes, info_);
  }

  const TaskInfo& info() const override { return info_; }
  SceneSource scene() const override { return scene_source(scene_); }
  std::string document() const override { return mjcf::compose(scene_, mjcf::Detail::kFull); }

  void bind(const Bindings& bindings) override {
    engine_ = bindings;
    ColumnStore& memory = *bindings.memory;
    for (PressButton& button : buttons_) button.bind(bindings);
    reward_dict_.bind(bindings, kRewardTerms);
    flash_color_ = memory.add<std::int32_t>("flash_color");
    memory.limit("flash_color", 0, kColors - 1);
    trigger_count_ = memory.add<std::int32_t>("flash_trigger_count");
    duration_ = memory.add<std::int32_t>("flash_duration", 1, "control steps");
    disc_xy_ = memory.add<double>("disc_xy", 2, "m");
    now_on_disc_ = memory.add<std::uint8_t>("now_on_disc", cubes_);
    sticky_ = memory.add<std::uint8_t>("cubes_on_disc", cubes_, "", "have been on the disc");
    flash_start_ = memory.add<std::int32_t>("flash_start", 1, "control steps");
    was_correct_ = memory.add<std::uint8_t>("was_correct");
    has_failed_ = memory.add<std::uint8_t>("has_failed");
    goal_ = memory.add<double>("obj_to_goal_pos", 3, "m");
    bind_info(*bindings.outputs);
  }

  // Nothing shows the colour after the flash, whenever that comes.
  int cue_end(int env) const override {
    if (flash_triggered_[env] == 0) return info_.horizon;
    return flash_start_[env] + duration_[env];
  }

  // --- sampling (procedural 4.3) ---

  void reset(const Episode& episode) override {
    const int env = episode.env();
    flash_color_[env] = episode.integer(kFlashColor, 0, kColors - 1);
    trigger_count_[env] = episode.integer(kTriggerCount, 1, most_triggers(cubes_));
    duration_[env] =
        episode.integer(kDuration, FLASH_DURATION_STEPS.low, FLASH_DURATION_STEPS.high);
    const Vec2 disc(episode.real(kDiscX, DISC_X_MIN, DISC_X_MAX),
                    episode.real(kDiscY, DISC_Y_MIN, DISC_Y_MAX));
    Eigen::Map<Vec2>(disc_xy_.row(env)) = disc;
    pressed_button_[env] = -1;
    place_cubes(episode, disc);
    const double pos[3] = {disc.x(), disc.y(), DISC_HALF_HEIGHT};
    engine_.state->place_prop(env, disc_, pos, mjcf::kDiscQuat.data());
    for (int color = 0; color < kColors; ++color) {
      button(color).reset(env,
                          disc + Vec2(BUTTON_X_OFFSET_FROM_DISC, (color - 1) * BUTTON_SPACING));
    }
    const double lamp[3] = {disc.x() + LAMP_X_OFFSET_FROM_DISC, disc.y() + LAMP_Y_OFFSET_FROM_DISC,
                            0};
    lamp_.place(*engine_.state, env, lamp);
  }

  // --- cubes on the disc, flash and buttons (procedural 4.4) ---

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      count_cubes(env);
      Flash flash{flash_triggered_[env] != 0, flash_start_[env]};
      const bool lit = update_flash(flash, n_on_disc_[env], trigger_count_[env], duration_[env],
                                    engine_.state->elapsed[env]);
      flash_triggered_[env] = flash.triggered ? 1 : 0;
      flash_start_[env] = flash.start;
      flash_active_[env] = lit ? 1 : 0;
      lamp_.shine(
          *engine_.state, env,
          lit ? LampLight{FLASH_COLORS[static_cast<std::size_t>(flash_color_[env])], kFlashEmission}
              : LampLight{kBulbOff, 0});
      for (const PressButton& button : buttons_) button.follow_tool(env, true);
    }
  }

  // --- success, failure and info (procedural 4.4 to 4.6) ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const bool all = all_on_disc_[env] != 0;
      for (int color = 0; color < kColors; ++color) {
        const bool counts = all && pressed_button_[env] < 0 && button(color).pressed(env);
        if (counts) pressed_button_[env] = color;
      }
      const bool pressed = pressed_button_[env] >= 0;
      const bool correct = pressed_button_[env] == flash_color_[env];
      was_correct_[env] |= pressed && correct && all ? 1 : 0;
      has_failed_[env] |= pressed && !correct ? 1 : 0;
      engine_.success[env] = was_correct_[env] != 0 && all ? 1 : 0;
      engine_.failed[env] = has_failed_[env];
      engine_.oracle_info[env] = flash_color_[env];
      shown_color_[env] = flash_color_[env];
      aim(env);
      reward_dict_.publish(env);
    }
  }

  // --- reward (procedural 4.7) ---

  void dense_reward(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const PressButton& right = button(flash_color_[env]);
      GatherRewardInputs in;
      in.goal_distance = Eigen::Map<const Eigen::Vector3d>(goal_.row(env)).norm();
      in.cubes_on_disc = static_cast<double>(n_on_disc_[env]) / cubes_;
      in.all_on_disc = all_on_disc_[env] != 0;
      in.correct_depth = right.depth(env) / right.params().BUTTON_CAP_TRAVEL;
      in.haste = measure_haste(engine_, env, FirstChange::kFromZero);
      in.failed = engine_.failed[env] != 0;
      in.success = engine_.success[env] != 0;
      const GatherRewardTerms terms = gather_reward(in);
      *out.row(env) = static_cast<float>(terms.reward);
      const std::array<double, kRewardTerms> row = {terms.reaching,
                                                    terms.progress,
                                                    static_cast<double>(n_on_disc_[env]),
                                                    terms.press,
                                                    terms.smooth.penalty,
                                                    terms.smooth.action_l2,
                                                    terms.smooth.action_delta_l2,
                                                    terms.smooth.qvel_l2};
      reward_dict_.note(env, row);
    }
  }

  // --- observation (procedural 4.6) ---

  void observe(Range envs, FloatRows out) override {
    const State& state = *engine_.state;
    for (int env = envs.begin; env < envs.end; ++env) {
      RowWriter row(out.row(env));
      row.add(goal_.row(env), 3);
      row.add(flash_color_[env]);
      row.add(state.prop_pos_of(env, disc_), 3);
      row.add(state.prop_quat_of(env, disc_), 4);
      for (int cube = 0; cube < cubes_; ++cube) row.add(sticky_.row(env)[cube]);
      row.add(n_on_disc_[env]);
      row.add(all_on_disc_[env]);
      row.add(flash_active_[env]);
      row.add(flash_color_[env]);
      row.add(pressed_button_[env]);
      for (int cube = 0; cube < cubes_; ++cube) {
        row.add(state.prop_pos_of(env, cube), 3);
        row.add(state.prop_quat_of(env, cube), 4);
      }
    }
  }

  // --- oracle (procedural 4.8, 4.9) ---

  void act(Range envs, bool blind, FloatRows actions) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      float* action = actions.row(env);
      if (bring_cubes(env, action)) press(env, blind ? guess(env) : flash_color_[env], action);
      slow_down(*engine_.state, env, kTableHeight, action);
    }
  }

 private:
  static mjcf::Scene cubes_and_disc(int cubes) {
    mjcf::Scene scene;
    scene.render_camera = mjcf::RenderCamera::kB;
    const Vec2 disc((DISC_X_MIN + DISC_X_MAX) / 2, (DISC_Y_MIN + DISC_Y_MAX) / 2);
    for (int cube = 0; cube < cubes; ++cube) {
      scene.props.push_back(mjcf::cube("gather_cube_" + std::to_string(cube), CUBE_HALF_SIZE,
                                       FLASH_COLORS[static_cast<std::size_t>(cube % kColors)]));
      const Vec2 place = cluster_place(cube, cubes, CUBE_HALF_SIZE, disc);
      scene.props.back().pos = {place.x(), place.y(), CUBE_HALF_SIZE};
    }
    scene.props.push_back(mjcf::disc("target_disc", DISC_RADIUS, DISC_HALF_HEIGHT, kDiscColor));
    return scene;
  }

  void bind_info(ColumnStore& info) {
    n_on_disc_ = info.add<std::int32_t>("n_on_disc", 1, "", "cubes that have been on the disc");
    all_on_disc_ = info.add<std::uint8_t>("all_on_disc", 1, "", "all of them are, and rest");
    flash_active_ = info.add<std::uint8_t>("flash_active");
    flash_triggered_ = info.add<std::uint8_t>("flash_triggered");
    shown_color_ = info.add<std::int32_t>("flash_color");
    pressed_button_ = info.add<std::int32_t>("pressed_button", 1, "", "-1: none");
    info.limit("pressed_button", -1, kColors - 1);
    obj_to_goal_pos_ = info.add<float>("obj_to_goal_pos", 3, "m", "next goal minus TCP position");
  }

  const PressButton& button(int color) const { return buttons_[static_cast<std::size_t>(color)]; }
  Vec2 disc(int env) const { return Eigen::Map<const Vec2>(disc_xy_.row(env)); }
  Eigen::Vector3d cube_pos(int env, int cube) const {
    return Eigen::Map<const Eigen::Vector3d>(engine_.state->prop_pos_of(env, cube));
  }
  Eigen::Vector3d tcp(int env) const {
    return Eigen::Map<const Eigen::Vector3d>(engine_.state->tcp_pos.row(env));
  }

  void place_cubes(const Episode& episode, const Vec2& disc) const {
    const double* pinned = episode.pinned(kCubeJitter);
    RandomStream random = episode.stream(kCubeJitter);
    for (int cube = 0; cube < cubes_; ++cube) {
      Vec2 place = cluster_place(cube, cubes_, CUBE_HALF_SIZE, disc);
      for (int i = 0; i < 2; ++i) {
        place[i] += pinned != nullptr ? pinned[2 * cube + i] : random.uniform(-kJitter, kJitter);
      }
      const double pos[3] = {place.x(), place.y(), CUBE_HALF_SIZE};
      engine_.state->place_prop(episode.env(), cube, pos, kUpright);
    }
  }

  void count_cubes(int env) const {
    int sticky = 0;
    bool all = true;
    for (int cube = 0; cube < cubes_; ++cube) {
      const Eigen::Map<const Eigen::Vector3d> velocity(engine_.state->prop_qvel_of(env, cube));
      const bool on = is_on_disc(cube_pos(env, cube), velocity, disc(env));
      now_on_disc_.row(env)[cube] = on ? 1 : 0;
      sticky_.row(env)[cube] |= on ? 1 : 0;
      sticky += sticky_.row(env)[cube];
      all = all && on;
    }
    n_on_disc_[env] = sticky;
    all_on_disc_[env] = all ? 1 : 0;
  }

  // The goal vector: to a cube that is still to be moved, to the disc while one is held, and to the
  // button at last.
  void aim(int env) const {
    constexpr double kAboveButton = 0.005;  // m
    Eigen::Map<Eigen::Vector3d> goal(goal_.row(env));
    goal.setZero();
    if (all_on_disc_[env] != 0) {
      const PressButton& right = button(flash_color_[env]);
      const Vec2 center = right.center(env);
      if (pressed_button_[env] < 0) {
        goal =
            Eigen::Vector3d(center.x(), center.y(), right.top_height() + kAboveButton) - tcp(env);
      }
    } else if (const int cube = nearest_unplaced(env); cube >= 0) {
      goal = cube_pos(env, cube) - tcp(env);
      if (goal.norm() < GRASP_THRESH) {
        goal = Eigen::Vector3d(disc(env).x(), disc(env).y(), kOnDisc) - tcp(env);
      }
    }
    for (int i = 0; i < 3; ++i) obj_to_goal_pos_.row(env)[i] = static_cast<float>(goal[i]);
  }

  // Of the cubes that have never been on the disc, the one nearest to the tool; -1: none.
  int nearest_unplaced(int env) const {
    int nearest = -1;
    double least = 0;
    for (int cube = 0; cube < cubes_; ++cube) {
      if (sticky_.row(env)[cube] != 0) continue;
      const double distance = (cube_pos(env, cube) - tcp(env)).norm();
      if (nearest >= 0 && distance >= least) continue;
      nearest = cube;
      least = distance;
    }
    return nearest;
  }

  // --- oracle ---

  static constexpr double kTableHeight = 0.05;   // m, of the TCP: where the tool is slowest
  static constexpr double kTravelHeight = 0.13;  // m: a cube in the hand passes over all others
  static constexpr double kClearance = 0.06;     // m above a cube that was left
  static constexpr double kOpening = 0.44;       // 26 mm per finger: clear of the neighbours
  static constexpr Lean kLean{.reach = 0.77, .per_metre = 4.0, .most = 0.12};

  // A grid around the middle of the disc, the far end last. The fingers close along y, so the rows
  // need more room.
  Eigen::Vector3d place_of(int env, int cube) const {
    static constexpr std::array<std::array<int, 2>, kMaxCubes> kOrder = {
        {{0, 0}, {-1, 0}, {1, 0}, {-1, -1}, {0, -1}, {-1, 1}, {0, 1}, {1, -1}, {1, 1}}};
    constexpr double kPitchX = 0.052;  // m
    constexpr double kPitchY = 0.066;  // m
    const auto& [column, row] = kOrder[static_cast<std::size_t>(cube)];
    return {disc(env).x() + column * kPitchX, disc(env).y() + row * kPitchY, kOnDisc};
  }

  // True once all cubes lie on the disc and the tool is clear of them.
  bool bring_cubes(int env, float* action) const {
    const State& state = *engine_.state;
    for (int cube = 0; cube < cubes_; ++cube) {
      const Eigen::Vector3d place = place_of(env, cube);
      Grip grip{.prop = cube, .opening = kOpening, .travel_height = kTravelHeight};
      if (!is_held(state, env, cube)) {
        grip.tool = lean_outwards(tool_for_cube(state, env, cube), cube_pos(env, cube), kLean);
        if (has_landed(env, cube)) {
          if (!leave_cube(env, grip, action)) return false;
          continue;
        }
      } else {
        grip.tool = lean_outwards(kToolDown, place, kLean);
      }
      if (!bring(state, env, grip, place, action)) return false;
    }
    return true;
  }

  bool has_landed(int env, int cube) const {
    constexpr double kRim = 0.005;  // m
    const Eigen::Vector3d offset =
        cube_pos(env, cube) - Eigen::Vector3d(disc(env).x(), disc(env).y(), kOnDisc);
    return offset.head<2>().norm() < DISC_ON_THRESH - kRim && std::abs(offset.z()) < kRim;
  }

  // Only the cube between the fingers has to be left; others may stand close by.
  bool leave_cube(int env, const Grip& grip, float* action) const {
    constexpr double kBetweenFingers = 0.02;  // m
    const Eigen::Vector3d offset = cube_pos(env, grip.prop) - tcp(env);
    if (offset.head<2>().norm() > kBetweenFingers) return true;
    return leave(*engine_.state, env, grip, kClearance, action);
  }

  void press(int env, int color, float* action) const {
    if (pressed_button_[env] >= 0) {
      hold_tool(kGripperClosed, action);
      return;
    }
    const Eigen::Vector3d goal = button(color).next_waypoint(env, kTravelHeight);
    servo_tool(*engine_.state, env, over_the_top(*engine_.state, env, goal, kTravelHeight),
               kToolDown, kGripperClosed, action);
  }

  // The button that an agent without memory would press.
  int guess(int env) const {
    const State& state = *engine_.state;
    RandomStream random(state.seed[env], state.episode[env], kPurposeBlindGuess);
    return random.integer(0, kColors - 1);
  }

  int cubes_;
  TaskInfo info_;
  mjcf::Scene scene_;
  int disc_;  // index of the prop
  std::array<PressButton, kColors> buttons_;
  Lamp lamp_;
  Bindings engine_;
  RewardDict reward_dict_;
  Column<std::int32_t> flash_color_;
  Column<std::int32_t> trigger_count_;
  Column<std::int32_t> duration_;
  Column<double> disc_xy_;            // (2) m
  Column<std::uint8_t> now_on_disc_;  // (cubes)
  Column<std::uint8_t> sticky_;       // (cubes)
  Column<std::int32_t> flash_start_;
  Column<std::uint8_t> was_correct_;
  Column<std::uint8_t> has_failed_;
  Column<double> goal_;  // (3) m: obj_to_goal_pos in full precision
  Column<std::int32_t> n_on_disc_;
  Column<std::uint8_t> all_on_disc_;
  Column<std::uint8_t> flash_active_;
  Column<std::uint8_t> flash_triggered_;
  Column<std::int32_t> shown_color_;
  Column<std::int32_t> pressed_button_;
  Column<float> obj_to_goal_pos_;  // (3) m
};

}  // namespace

std::unique_ptr<Task> make_gather_and_recall(const RegistryEntry& entry) {
  return std::make_unique<GatherAndRecall>(entry, gather_cubes(entry.id));
}

}  // namespace engram::tasks
