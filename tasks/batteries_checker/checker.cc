#include "tasks/batteries_checker/checker.h"

#include <algorithm>
#include <array>
#include <string>

#include "core/base/index.h"
#include "core/image/overlay.h"
#include "mjcf/scene.h"
#include "tasks/batteries_checker/annotator.h"
#include "tasks/batteries_checker/check_columns.h"
#include "tasks/batteries_checker/expert.h"
#include "tasks/batteries_checker/params.h"
#include "tasks/batteries_checker/rack.h"
#include "tasks/batteries_checker/reward.h"
#include "tasks/common/family_base.h"
#include "tasks/common/lamp.h"
#include "tasks/common/reward_dict.h"
#include "tasks/common/variant.h"

namespace engram::tasks {
namespace {

// --- parameters (see also tasks/batteries_checker/params.h) ---

constexpr double kLampEmission = 0.3;
constexpr double kDisplaced = 3;  // times the tolerance of a slot: where a checked battery is lost

class BatteryChecker final : public FamilyBase {
 public:
  BatteryChecker(const RegistryEntry& entry, const BatteryParams& params)
      : FamilyBase(entry),
        params_(params),
        variables_(RandomVariables(info_.random_variables), params),
        options_(TaskOptions(info_.options)),
        rack_(scene_, params),
        button_(scene_, "battery_button", params.button),
        lamp_(scene_, "battery_checker_lamp"),
        expert_({.engine = engine_,
                 .info = info_,
                 .params = params_,
                 .rack = rack_,
                 .button = button_,
                 .check = check_}),
        annotator_({.params = params_, .rack = rack_, .button = button_, .check = check_}) {
    scene_.render_view = mjcf::RenderView::kTable;
    describe_batteries(params, info_);
    info_.reward_terms = reward_terms_of(BatteryReward{});
    declare_state(*this);
  }

  void bind(const Bindings& bindings) override {
    FamilyBase::bind(bindings);
    check_all_ = options_.check_all.is_on(bindings);
    describe_chance(params_, check_all_, info_);
    upstream_rewards_ = options_.upstream_rewards.is_on(bindings);
    rack_.bind(bindings);
    button_.bind(bindings);
    reward_dict_.bind(bindings, info_.reward_terms.size());
    check_.bind(bindings, rack_.batteries());
    check_.empty_socket_idx = static_cast<int>(options_.socket_battery_idx.value(bindings));
  }

  // The lamp may inform at any time.
  int cue_end(int /*env*/) const override { return info_.horizon; }

  // --- sampling ---

  void reset(const Episode& episode) override {
    const int env = episode.env();
    const Vec2 tray(variables_.tray_x.sample(episode), variables_.tray_y.sample(episode));
    check_.working_set[env] = static_cast<std::int32_t>(draw_working(episode));
    check_.active[env] = -1;
    check_.socket_idx[env] = check_.empty_socket_idx;
    rack_.reset(env, tray);
    button_.reset(env, tray + Vec2(BUTTON_X_OFFSET_FROM_TRAY, BUTTON_Y_OFFSET_FROM_TRAY),
                  mjcf::kQuarterTurn);
    const Vec2 foot =
        rack_.socket(env).head<2>() + Vec2(LAMP_X_OFFSET_FROM_SOCKET, LAMP_Y_OFFSET_FROM_SOCKET);
    const double lamp[3] = {foot.x(), foot.y(), 0};
    lamp_.place(*engine_.state, env, lamp, mjcf::kQuarterTurn.data());
  }

  // --- phases: the stages of a check ---

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      check_.grasped_set[env] = static_cast<std::int32_t>(rack_.grasped(env));
      button_.follow_tool(env, true);
      CheckInputs in;
      in.in_socket = rack_.in_socket(env) & ~check_.held(env);
      in.home = rack_.home(env) & ~check_.held(env) & ~in.in_socket;
      in.working = check_.working(env);
      in.pressed = button_.press_once(env, true, true);
      in.afterglow = params_.LAMP_AFTERGLOW_STEPS;
      const CheckState before = check_.load(env);
      CheckState state = before;
      CheckEvents events = check_step(in, state);
      note_answer(env, before, state, in.pressed);
      if (events.insert) rack_.snap(env, state.active);
      check_.solved[env] = is_solved(env, state) ? 1 : 0;
      if (params_.easy && return_by_itself(state, events)) rack_.send_home(env, state.active);
      if (events.confirm) ++check_.rounds[env];
      check_.store(env, state);
      check_.store(env, events, in.pressed);
      const LampLight light =
          events.lamp ? LampLight{LAMP_ON_COLOR, kLampEmission} : LampLight{LAMP_OFF_COLOR, 0};
      lamp_.shine(*engine_.state, env, light);
    }
  }

  // --- success ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      engine_.success[env] = check_.solved[env];
      const BatterySet checked = check_.checked(env);
      check_.checked_count[env] = count(checked);
      check_.found_count[env] = count(check_.found(env));
      check_.all_checked[env] = check_.checked_count[env] >= params_.ACTIVE_BATTERY_COUNT ? 1 : 0;
      check_.active_count[env] = params_.ACTIVE_BATTERY_COUNT;
      check_.target_count[env] = params_.WORKING_BATTERY_COUNT;
      check_.action_mask[env] = 1;
      check_.press_depth[env] = static_cast<float>(button_.depth(env));
      RowWriter(check_.obj_to_goal_pos.row(env)).add(rack_.socket(env) - tcp_pos(env));
      list_working(env, engine_.oracle_info.row(env));
      reward_dict_.publish(env);
    }
  }

  // --- reward ---

  void dense_reward(Range envs, FloatRows out) override {
    reward_dict_.write(envs, out, [&](int env) { return measure(env); });
  }

  // --- observation ---

  template <class Visitor>
  void state_row(Visitor& row, int env) const {
    row.field("battery_pose", 7 * NUM_BATTERIES, "m", "pose of every battery",
              [&](RowWriter& out) { add_batteries(out, env); });
    row.field("tray_pose", 7, "m", "", [&] { return prop_pose(env, rack_.tray_prop()); });
    row.field("socket_pose", 7, "m", "", [&] { return prop_pose(env, rack_.socket_prop()); });
    row.field("button_base_pose", 7, "m", "", [&] { return button_.base_pose(env); });
    row.field("button_cap_pose", 7, "m", "", [&] { return button_.cap_pose(env); });
    row.field("lamp_off_pose", 7, "m", "z = 1000 while the lamp is on",
              [&](RowWriter& out) { add_bulb(out, env, check_.lit[env] == 0); });
    row.field("lamp_on_pose", 7, "m", "z = 1000 while the lamp is off",
              [&](RowWriter& out) { add_bulb(out, env, check_.lit[env] != 0); });
    row.field("action_stage", 1, "", "0: insert, 1: return, 2: confirm",
              [&] { return check_.stage[env]; });
    row.field("action_mask", 1, "", "always 1", [&] { return check_.action_mask[env]; });
    row.field("active_mask", NUM_BATTERIES, "", "batteries that take part",
              [&](RowWriter& out) { add_active_mask(out); });
    row.field("oracle_info", params_.WORKING_BATTERY_COUNT, "",
              "slots of the working batteries, ascending",
              [&](RowWriter& out) { add_working(out, env); });
  }
  void observe(Range envs, FloatRows out) override { write_state(*this, envs, out); }

  // --- expert ---

  const Expert& expert() const override { return expert_; }
  const Annotator* annotator() const override { return &annotator_; }

  // --- overlay ---

  void overlay(int env, Overlay& out) const override {
    out.add(OverlayText{{10, 150},
                        "Working found: " + std::to_string(check_.found_count[env]) + "/" +
                            std::to_string(params_.WORKING_BATTERY_COUNT),
                        0.8});
  }

 private:
  BatterySet draw_working(const Episode& episode) const {
    BatterySet set = 0;
    if (const double* pinned = variables_.working.pinned(episode)) {
      for (int i = 0; i < params_.WORKING_BATTERY_COUNT; ++i) {
        set |= battery_bit(static_cast<int>(pinned[i]));
      }
      return set;
    }
    std::array<int, NUM_BATTERIES> order{};
    const auto active = at(params_.ACTIVE_BATTERY_COUNT);
    variables_.working.stream(episode).permutation(std::span(order).first(active));
    for (int i = 0; i < params_.WORKING_BATTERY_COUNT; ++i) {
      set |= battery_bit(order[at(i)]);
    }
    return set;
  }

  // Slots of working batteries; a made-up snapshot may claim more of them than there is room for.
  void list_working(int env, std::int32_t* out) const {
    const std::int32_t* const end = out + params_.WORKING_BATTERY_COUNT;
    for (int battery = 0; battery < params_.ACTIVE_BATTERY_COUNT && out < end; ++battery) {
      if (contains(check_.working(env), battery)) *out++ = battery;
    }
  }

  // Every working battery found; with check_all, every other one checked, too.
  bool is_search_over(const CheckState& state) const {
    return count(state.found) >= params_.WORKING_BATTERY_COUNT &&
           (!check_all_ || count(state.checked) >= params_.ACTIVE_BATTERY_COUNT);
  }

  // With check_all no checked battery is far from its slot.
  bool is_solved(int env, const CheckState& state) const {
    const BatterySet misplaced = check_all_ ? state.checked & ~rack_.home(env, kDisplaced) : 0;
    return is_search_over(state) && misplaced == 0;
  }

  // A press says that a battery has been dealt with: wrongly if it is not in its slot, or was
  // checked before. A press without a battery says nothing.
  void note_answer(int env, const CheckState& before, const CheckState& after, bool pressed) const {
    if (!pressed || before.active < 0) return;
    const bool confirmed = after.active < 0;
    if (!confirmed || contains(before.checked, before.active)) {
      engine_.answers.give(env, before.active, false);
    } else if (is_search_over(after)) {
      engine_.answers.give(env, before.active, true);
    }
  }

  BatteryReward measure(int env) const {
    const Eigen::Vector3d tool = tcp_pos(env);
    const int active = std::max(check_.active[env], 0);
    BatteryReward in;
    in.stage = check_.stage[env];
    for (int battery = 0; battery < rack_.batteries(); ++battery) {
      if (contains(check_.checked(env), battery)) continue;
      const double distance = (rack_.pos(env, battery) - tool).norm();
      const bool nearer = in.unchecked_distance < 0 || distance < in.unchecked_distance;
      if (nearer) in.unchecked_distance = distance;
    }
    if (const int held_one = lowest(check_.held(env)); held_one >= 0) {
      in.carry_distance = (rack_.pos(env, held_one) - rack_.socket(env)).norm();
    }
    in.home_distance = (rack_.pos(env, active) - rack_.slot(env, active)).norm();
    in.button_distance = (button_.above(env) - tool).norm();
    in.socket_distance = (rack_.socket(env) - tool).norm();
    in.press_depth = button_.press_fraction(env);
    in.pressed = check_.press_event[env] != 0;
    in.events = {.insert = check_.insert_event[env] != 0,
                 .returned = check_.return_event[env] != 0,
                 .confirm = check_.confirm_event[env] != 0,
                 .newly_found = check_.newly_found[env] != 0};
    in.checked = check_.checked_count[env];
    in.found = check_.found_count[env];
    in.working = check_.target_count[env];
    in.action_cost = measure_action_cost(engine_, env, FirstChange::kFromZero);
    in.success = engine_.success[env] != 0;
    in.smoothness = params_.smoothness;
    in.upstream = upstream_rewards_;
    return in;
  }

  // Upstream has a bulb for each state of the lamp.
  void add_bulb(RowWriter& row, int env, bool shown) const {
    const double* foot = engine_.state->prop_pos_of(env, lamp_.bulb());
    const double pos[3] = {foot[0], foot[1], shown ? foot[2] : kHiddenOffset};
    row.add(Pose{pos, mjcf::kQuarterTurn.data()});
  }
  // Batteries that do not take part are away.
  void add_batteries(RowWriter& row, int env) const {
    static constexpr double kAway[3] = {0, 0, kHiddenOffset};
    for (int battery = 0; battery < NUM_BATTERIES; ++battery) {
      row.add(battery < rack_.batteries() ? prop_pose(env, rack_.prop(battery))
                                          : Pose{kAway, mjcf::kBatteryQuat.data()});
    }
  }
  void add_active_mask(RowWriter& row) const {
    for (int battery = 0; battery < NUM_BATTERIES; ++battery) {
      row.add(battery < rack_.batteries() ? 1 : 0);
    }
  }
  void add_working(RowWriter& row, int env) const {
    std::array<std::int32_t, NUM_BATTERIES> slots{};
    list_working(env, slots.data());
    row.add(slots.data(), params_.WORKING_BATTERY_COUNT);
  }

  BatteryParams params_;
  BatteryVariables variables_;
  BatteryOptions options_;
  BatteryRack rack_;
  PressButton button_;
  Lamp lamp_;
  bool check_all_ = false;
  bool upstream_rewards_ = false;
  RewardDict reward_dict_;
  CheckColumns check_;
  BatteryExpert expert_;
  BatteryAnnotator annotator_;
};

}  // namespace

constexpr auto kEasyRows = rows_of(kEasyVariants);
constexpr auto kHardRows = rows_of(kHardVariants);

const Family kBatteriesCheckerEasy = {
    .name = "BatteriesCheckerEasy",
    .memory_type = "Checklist",
    .instruction =
        "Find all working batteries by inserting each one into the socket, observing the lamp "
        "result, and then pressing the button to confirm.",
    .tasks = kEasyRows,
    .make = make_variant<BatteryChecker, kEasyVariants>,
    .expectations = {.min_reward = -0.0517, .max_reward = 0.705},
    .memory = {.no_counterfactuals = "there is no cue: the robot finds out by tests of its own"}};

const Family kBatteriesCheckerHard = {
    .name = "BatteriesCheckerHard",
    .memory_type = "Checklist",
    .instruction =
        "Find all working batteries by inserting each one into the socket, observing the lamp "
        "result, returning it from the socket to its initial slot, and then pressing the "
        "button to confirm.",
    .tasks = kHardRows,
    .make = make_variant<BatteryChecker, kHardVariants>,
    .expectations = {.min_reward = -0.0517, .max_reward = 0.705},
    .memory = {.no_counterfactuals = "there is no cue: the robot finds out by tests of its own"}};

}  // namespace engram::tasks
