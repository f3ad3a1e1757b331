#include "tasks/batteries_checker/checker.h"

#include <algorithm>
#include <array>
#include <string>

#include "core/picture/overlay.h"
#include "mjcf/scene.h"
#include "tasks/batteries_checker/oracle.h"
#include "tasks/batteries_checker/params.h"
#include "tasks/batteries_checker/rack.h"
#include "tasks/batteries_checker/rules.h"
#include "tasks/parts/lamp.h"
#include "tasks/parts/reward_dict.h"
#include "tasks/parts/state_row.h"
#include "tasks/parts/task_info.h"

namespace engram::tasks {
namespace {

constexpr double kLampEmission = 0.3;
constexpr double kDisplaced = 3;  // times the tolerance of a slot: where a checked battery is lost

class BatteryChecker final : public Task {
 public:
  BatteryChecker(const RegistryEntry& entry, const BatteryParams& params)
      : params_(params),
        scene_{.props = {}, .render_camera = mjcf::RenderCamera::kB},
        rack_(scene_, params.ACTIVE_BATTERY_COUNT),
        button_(scene_, "battery_button", battery_button()),
        lamp_(scene_, "battery_checker_lamp"),
        oracle_(rack_, button_) {
    info_ = describe(entry);
    describe_batteries(params, info_);
  }

  const TaskInfo& info() const override { return info_; }
  SceneSource scene() const override { return scene_source(scene_); }
  std::string document() const override { return mjcf::compose(scene_, mjcf::Detail::kFull); }

  void bind(const Bindings& bindings) override {
    engine_ = bindings;
    upstream_rewards_ = bindings.options[kUpstreamRewards] != 0;
    ColumnStore& memory = *bindings.memory;
    rack_.bind(bindings);
    button_.bind(bindings);
    reward_dict_.bind(bindings, kBatteryRewardTerms);
    working_ = memory.add<std::int32_t>("working", 1, "", "a bit per slot");
    checked_ = memory.add<std::int32_t>("checked", 1, "", "a bit per slot");
    found_ = memory.add<std::int32_t>("found", 1, "", "a bit per slot");
    grasped_ = memory.add<std::int32_t>("grasped", 1, "", "a bit per slot");
    afterglow_ = memory.add<std::int32_t>("afterglow", 1, "control steps");
    rounds_ = memory.add<std::int32_t>("rounds", 1, "", "confirmations so far");
    lit_ = memory.add<std::uint8_t>("lit");
    newly_found_ = memory.add<std::uint8_t>("newly_found");
    solved_ = memory.add<std::uint8_t>("solved");
    const int all = (1 << rack_.batteries()) - 1;
    for (const char* set : {"working", "checked", "found", "grasped"}) memory.limit(set, 0, all);
    bind_info(*bindings.outputs);
    bindings.outputs->limit("action_stage", 0, 2);
    bindings.outputs->limit("active_battery_idx", -1, rack_.batteries() - 1);
    bindings.outputs->limit("socket_battery_idx", -1, rack_.batteries() - 1);
  }

  // The lamp may tell at any time.
  int cue_end(int /*env*/) const override { return info_.horizon; }

  // --- sampling (procedural 5.3) ---

  void reset(const Episode& episode) override {
    const int env = episode.env();
    const Vec2 tray(episode.real(kTrayXDraw, kTrayX[0], kTrayX[1]),
                    episode.real(kTrayYDraw, kTrayY[0], kTrayY[1]));
    working_[env] = static_cast<std::int32_t>(draw_working(episode));
    active_[env] = -1;
    socket_idx_[env] = -1;
    rack_.reset(env, tray);
    button_.reset(env, tray + Vec2(BUTTON_X_OFFSET_FROM_TRAY, BUTTON_Y_OFFSET_FROM_TRAY),
                  mjcf::kQuarterTurn);
    const Vec2 foot =
        rack_.socket(env).head<2>() + Vec2(LAMP_X_OFFSET_FROM_SOCKET, LAMP_Y_OFFSET_FROM_SOCKET);
    const double lamp[3] = {foot.x(), foot.y(), 0};
    lamp_.place(*engine_.state, env, lamp, mjcf::kQuarterTurn.data());
  }

  // --- stages (procedural 5.5) ---

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      grasped_[env] = static_cast<std::int32_t>(rack_.grasped(env));
      button_.follow_tool(env, true);
      CheckInputs in;
      in.in_socket = rack_.in_socket(env) & ~held(env);
      in.home = rack_.home(env) & ~held(env) & ~in.in_socket;
      in.working = working(env);
      in.pressed = button_.press_once(env, true, true);
      CheckState state = load(env);
      CheckEvents events = check_step(in, state);
      if (events.insert) rack_.snap(env, state.active);
      solved_[env] = is_solved(env, state) ? 1 : 0;
      if (params_.easy && return_by_itself(state, events)) rack_.send_home(env, state.active);
      if (events.confirm) ++rounds_[env];
      store(env, state);
      store_events(env, events, in.pressed);
      const LampLight light =
          events.lamp ? LampLight{LAMP_ON_COLOR, kLampEmission} : LampLight{LAMP_OFF_COLOR, 0};
      lamp_.shine(*engine_.state, env, light);
    }
  }

  // --- success and info (procedural 5.5, 5.6) ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      engine_.success[env] = solved_[env];
      const BatterySet checked = bits(checked_, env);
      checked_count_[env] = count(checked);
      found_count_[env] = count(bits(found_, env));
      all_checked_[env] = checked_count_[env] >= params_.ACTIVE_BATTERY_COUNT ? 1 : 0;
      active_count_[env] = params_.ACTIVE_BATTERY_COUNT;
      target_count_[env] = params_.WORKING_BATTERY_COUNT;
      action_mask_[env] = 1;
      press_depth_[env] = static_cast<float>(button_.depth(env));
      const Eigen::Vector3d goal = rack_.socket(env) - tcp(env);
      for (int i = 0; i < 3; ++i) obj_to_goal_pos_.row(env)[i] = static_cast<float>(goal[i]);
      list_working(env, engine_.oracle_info.row(env));
      reward_dict_.publish(env);
    }
  }

  // --- reward (procedural 5.7) ---

  void dense_reward(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const BatteryRewardInputs in = measure(env);
      const BatteryRewardTerms terms = battery_reward(in, upstream_rewards_);
      *out.row(env) = static_cast<float>(terms.reward);
      note_terms(env, in, terms);
    }
  }

  // --- observation (procedural 5.6) ---

  void observe(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      RowWriter row(out.row(env));
      static constexpr double kAway[3] = {0, 0, kHiddenOffset};
      for (int battery = 0; battery < NUM_BATTERIES; ++battery) {
        if (battery < rack_.batteries()) {
          add_prop(row, env, rack_.prop(battery));
        } else {
          add_pose(row, kAway, mjcf::kBatteryQuat.data());
        }
      }
      add_prop(row, env, rack_.tray_prop());
      add_prop(row, env, rack_.socket_prop());
      add_pose(row, button_.base_pos(env), button_.base_quat(env));
      add_pose(row, button_.cap_pos(env), button_.cap_quat(env));
      add_bulb(row, env, lit_[env] == 0);
      add_bulb(row, env, lit_[env] != 0);
      row.add(stage_[env]);
      row.add(action_mask_[env]);
      for (int battery = 0; battery < NUM_BATTERIES; ++battery) {
        row.add(battery < rack_.batteries() ? 1 : 0);
      }
      std::array<std::int32_t, NUM_BATTERIES> slots{};
      list_working(env, slots.data());
      for (int i = 0; i < params_.WORKING_BATTERY_COUNT; ++i) {
        row.add(slots[static_cast<std::size_t>(i)]);
      }
    }
  }

  // --- oracle (procedural 5.8) ---

  void act(Range envs, bool blind, FloatRows actions) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const CheckState state = load(env);
      BatteryChoice choice;
      if (blind) {
        choice = guess(env);
      } else {
        choice = {lowest(~state.checked & all_batteries()), state.active};
      }
      oracle_.act(*engine_.state, env, state, choice, actions.row(env));
    }
  }

  // --- overlay (common 11) ---

  void overlay(int env, Overlay& out) const override {
    out.add(OverlayText{{10, 150},
                        "Working found: " + std::to_string(found_count_[env]) + "/" +
                            std::to_string(params_.WORKING_BATTERY_COUNT),
                        0.8});
  }

 private:
  void bind_info(ColumnStore& info) {
    action_mask_ = info.add<std::uint8_t>("action_mask", 1, "", "always true");
    cue_mask_ = info.add<std::uint8_t>("cue_mask", 1, "", "always false");
    stage_ = info.add<std::int32_t>("action_stage", 1, "", "0: insert, 1: return, 2: confirm");
    active_ = info.add<std::int32_t>("active_battery_idx", 1, "", "of this round, -1: none");
    socket_has_battery_ = info.add<std::uint8_t>("socket_has_battery");
    socket_idx_ = info.add<std::int32_t>("socket_battery_idx", 1, "", "-1: none");
    socket_works_ = info.add<std::uint8_t>("socket_has_working");
    active_count_ = info.add<std::int32_t>("active_battery_count");
    checked_count_ = info.add<std::int32_t>("checked_count");
    found_count_ = info.add<std::int32_t>("found_working_count");
    target_count_ = info.add<std::int32_t>("target_working_count");
    all_checked_ = info.add<std::uint8_t>("all_checked");
    insert_event_ = info.add<std::uint8_t>("new_insert_event");
    return_event_ = info.add<std::uint8_t>("new_return_event");
    confirm_event_ = info.add<std::uint8_t>("new_confirm_event");
    press_event_ = info.add<std::uint8_t>("new_button_press_event");
    press_depth_ = info.add<float>("button_press_depth", 1, "m");
    obj_to_goal_pos_ = info.add<float>("obj_to_goal_pos", 3, "m", "socket minus TCP position");
  }

  static BatterySet bits(const Column<std::int32_t>& column, int env) {
    return static_cast<BatterySet>(column[env]);
  }
  BatterySet working(int env) const { return bits(working_, env); }
  BatterySet held(int env) const { return bits(grasped_, env); }
  BatterySet all_batteries() const { return battery_bit(params_.ACTIVE_BATTERY_COUNT) - 1; }
  Eigen::Vector3d tcp(int env) const {
    return Eigen::Map<const Eigen::Vector3d>(engine_.state->tcp_pos.row(env));
  }

  BatterySet draw_working(const Episode& episode) const {
    BatterySet set = 0;
    if (const double* pinned = episode.pinned(kWorking)) {
      for (int i = 0; i < params_.WORKING_BATTERY_COUNT; ++i) {
        set |= battery_bit(static_cast<int>(pinned[i]));
      }
      return set;
    }
    std::array<int, NUM_BATTERIES> order{};
    const auto active = static_cast<std::size_t>(params_.ACTIVE_BATTERY_COUNT);
    episode.stream(kWorking).permutation(std::span(order).first(active));
    for (int i = 0; i < params_.WORKING_BATTERY_COUNT; ++i) {
      set |= battery_bit(order[static_cast<std::size_t>(i)]);
    }
    return set;
  }

  // Slots of working batteries; a made-up snapshot may claim more of them than there is room for.
  void list_working(int env, std::int32_t* out) const {
    const std::int32_t* const end = out + params_.WORKING_BATTERY_COUNT;
    for (int battery = 0; battery < params_.ACTIVE_BATTERY_COUNT && out < end; ++battery) {
      if (contains(working(env), battery)) *out++ = battery;
    }
  }

  CheckState load(int env) const {
    return {stage_[env], active_[env], afterglow_[env], bits(checked_, env), bits(found_, env)};
  }
  void store(int env, const CheckState& state) const {
    stage_[env] = state.stage;
    active_[env] = state.active;
    afterglow_[env] = state.afterglow;
    checked_[env] = static_cast<std::int32_t>(state.checked);
    found_[env] = static_cast<std::int32_t>(state.found);
  }
  void store_events(int env, const CheckEvents& events, bool pressed) const {
    const auto flag = [](bool value) { return static_cast<std::uint8_t>(value ? 1 : 0); };
    insert_event_[env] = flag(events.insert);
    return_event_[env] = flag(events.returned);
    confirm_event_[env] = flag(events.confirm);
    newly_found_[env] = flag(events.newly_found);
    press_event_[env] = flag(pressed);
    socket_idx_[env] = events.socket_battery;
    socket_has_battery_[env] = flag(events.socket_battery >= 0);
    socket_works_[env] = flag(events.socket_works);
    lit_[env] = flag(events.lamp);
  }

  // Every battery checked, every working one found, and no checked one far from its slot.
  bool is_solved(int env, const CheckState& state) const {
    const BatterySet misplaced = state.checked & ~rack_.home(env, kDisplaced);
    return count(state.found) >= params_.WORKING_BATTERY_COUNT &&
           count(state.checked) >= params_.ACTIVE_BATTERY_COUNT && misplaced == 0;
  }

  BatteryRewardInputs measure(int env) const {
    constexpr double kAboveButton = 0.005;  // m
    const Eigen::Vector3d tool = tcp(env);
    const Vec2 button = button_.center(env);
    const Eigen::Vector3d above(button.x(), button.y(), button_.top_height() + kAboveButton);
    const int active = std::max(active_[env], 0);
    BatteryRewardInputs in;
    in.stage = stage_[env];
    for (int battery = 0; battery < rack_.batteries(); ++battery) {
      if (contains(bits(checked_, env), battery)) continue;
      const double distance = (rack_.pos(env, battery) - tool).norm();
      const bool nearer = in.unchecked_distance < 0 || distance < in.unchecked_distance;
      if (nearer) in.unchecked_distance = distance;
    }
    if (const int held_one = lowest(held(env)); held_one >= 0) {
      in.carry_distance = (rack_.pos(env, held_one) - rack_.socket(env)).norm();
    }
    in.home_distance = (rack_.pos(env, active) - rack_.slot(env, active)).norm();
    in.button_distance = (above - tool).norm();
    in.socket_distance = (rack_.socket(env) - tool).norm();
    in.press_depth = button_.depth(env) / button_.params().BUTTON_CAP_TRAVEL;
    in.pressed = press_event_[env] != 0;
    in.events = {.insert = insert_event_[env] != 0,
                 .returned = return_event_[env] != 0,
                 .confirm = confirm_event_[env] != 0,
                 .newly_found = newly_found_[env] != 0};
    in.haste = measure_haste(engine_, env, FirstChange::kFromZero);
    in.success = engine_.success[env] != 0;
    return in;
  }

  void note_terms(int env, const BatteryRewardInputs& in, const BatteryRewardTerms& terms) const {
    const auto flag = [](bool value) { return value ? 1.0 : 0.0; };
    const std::array<double, kBatteryRewardTerms> row = {flag(in.stage == STAGE_INSERT),
                                                         flag(in.stage == STAGE_RETURN),
                                                         flag(in.stage == STAGE_CONFIRM),
                                                         terms.reach,
                                                         terms.carry,
                                                         terms.back,
                                                         terms.button_reach,
                                                         terms.press,
                                                         flag(in.events.insert),
                                                         flag(in.events.returned),
                                                         flag(in.events.confirm),
                                                         flag(terms.newly_found),
                                                         flag(terms.wrong_press),
                                                         static_cast<double>(checked_count_[env]),
                                                         static_cast<double>(found_count_[env]),
                                                         static_cast<double>(target_count_[env]),
                                                         terms.smooth.action_l2,
                                                         terms.smooth.action_delta_l2,
                                                         terms.smooth.qvel_l2,
                                                         terms.smooth.penalty};
    reward_dict_.note(env, row);
  }

  static void add_pose(RowWriter& row, const double* pos, const double* quat) {
    row.add(pos, 3);
    row.add(quat, 4);
  }
  void add_prop(RowWriter& row, int env, int prop) const {
    add_pose(row, engine_.state->prop_pos_of(env, prop), engine_.state->prop_quat_of(env, prop));
  }
  // Upstream has a bulb for each state of the lamp.
  void add_bulb(RowWriter& row, int env, bool shown) const {
    const double* foot = engine_.state->prop_pos_of(env, lamp_.bulb());
    const double pos[3] = {foot[0], foot[1], shown ? foot[2] : kHiddenOffset};
    add_pose(row, pos, mjcf::kQuarterTurn.data());
  }

  // An agent without memory knows neither which batteries it has tested nor where the one in the
  // socket came from: it takes any, and puts it into any slot that is empty. It stops after as many
  // rounds as there are batteries.
  BatteryChoice guess(int env) const {
    const State& state = *engine_.state;
    if (rounds_[env] >= params_.ACTIVE_BATTERY_COUNT) return {};
    RandomStream random(state.seed[env], state.episode[env], kPurposeBlindGuess);
    BatteryChoice choice;
    int empty = 0;
    for (int round = 0; round <= rounds_[env]; ++round) {
      choice.battery = random.integer(0, params_.ACTIVE_BATTERY_COUNT - 1);
      empty = random.integer(0, NUM_BATTERIES - params_.ACTIVE_BATTERY_COUNT);
    }
    choice.slot = empty == 0 ? active_[env] : params_.ACTIVE_BATTERY_COUNT - 1 + empty;
    return choice;
  }

  BatteryParams params_;
  TaskInfo info_;
  mjcf::Scene scene_;
  BatteryRack rack_;
  PressButton button_;
  Lamp lamp_;
  BatteryOracle oracle_;
  Bindings engine_;
  bool upstream_rewards_ = false;
  RewardDict reward_dict_;
  Column<std::int32_t> working_;
  Column<std::int32_t> checked_;
  Column<std::int32_t> found_;
  Column<std::int32_t> grasped_;  // as read before any teleport of this step
  Column<std::int32_t> afterglow_;
  Column<std::int32_t> rounds_;
  Column<std::uint8_t> lit_;
  Column<std::uint8_t> newly_found_;
  Column<std::uint8_t> solved_;
  Column<std::uint8_t> action_mask_;
  Column<std::uint8_t> cue_mask_;
  Column<std::int32_t> stage_;
  Column<std::int32_t> active_;
  Column<std::uint8_t> socket_has_battery_;
  Column<std::int32_t> socket_idx_;
  Column<std::uint8_t> socket_works_;
  Column<std::int32_t> active_count_;
  Column<std::int32_t> checked_count_;
  Column<std::int32_t> found_count_;
  Column<std::int32_t> target_count_;
  Column<std::uint8_t> all_checked_;
  Column<std::uint8_t> insert_event_;
  Column<std::uint8_t> return_event_;
  Column<std::uint8_t> confirm_event_;
  Column<std::uint8_t> press_event_;
  Column<float> press_depth_;
  Column<float> obj_to_goal_pos_;  // (3) m
};

}  // namespace

std::unique_ptr<Task> make_battery_checker(const RegistryEntry& entry) {
  return std::make_unique<BatteryChecker>(entry, battery_params(entry.id));
}

}  // namespace engram::tasks
