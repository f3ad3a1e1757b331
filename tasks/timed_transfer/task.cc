#include "tasks/timed_transfer/task.h"

#include <algorithm>
#include <array>
#include <string>

#include "core/picture/overlay.h"
#include "mjcf/disc.h"
#include "mjcf/scene.h"
#include "tasks/parts/grasp_servo.h"
#include "tasks/parts/lamp.h"
#include "tasks/parts/layout.h"
#include "tasks/parts/phase_clock.h"
#include "tasks/parts/reward_dict.h"
#include "tasks/parts/state_row.h"
#include "tasks/parts/task_info.h"
#include "tasks/parts/variant.h"
#include "tasks/timed_transfer/rules.h"

namespace engram::tasks {
namespace {

struct Params {
  std::string_view id;
  int DELAY_STEPS;
};

constexpr std::array<Params, 6> kVariants = {{
    {"TimedTransferEasy-VLA-v0", 100},
    {"TimedTransferMedium-VLA-v0", 150},
    {"TimedTransferHard-VLA-v0", 200},
    {"TimedTransferEasy-Long-VLA-v0", 300},
    {"TimedTransferMedium-Long-VLA-v0", 500},
    {"TimedTransferHard-Long-VLA-v0", 1000},
}};

constexpr StepRange PRE_SIGNAL_STEPS{1, 3};
constexpr double DISC_RADIUS = 0.07;          // m
constexpr double DISC_HALF_HEIGHT = 0.003;    // m
constexpr double CUBE_HALF_SIZE = 0.02;       // m
constexpr double GOAL_THRESH = 0.05;          // m
constexpr double LAMP_FORWARD_OFFSET = 0.22;  // m
constexpr double DISC_SEPARATION = 0.22;      // m
constexpr double HEIGHT_OFFSET = 1000.0;
constexpr double kCenterX[2] = {-0.15, -0.05};                              // m
constexpr double kCenterY[2] = {-0.05, 0.05};                               // m
constexpr double kRestingHeight = 2 * DISC_HALF_HEIGHT + CUBE_HALF_SIZE;    // m, on a disc
constexpr double kOnRedHeight = 2 * DISC_HALF_HEIGHT + 3 * CUBE_HALF_SIZE;  // m
constexpr double kUpright[4] = {1, 0, 0, 0};

constexpr mjcf::Rgba kGreen = {30 / 255.0, 180 / 255.0, 30 / 255.0, 1};
constexpr mjcf::Rgba kRed = {200 / 255.0, 30 / 255.0, 30 / 255.0, 1};
constexpr mjcf::Rgba kBlue = {30 / 255.0, 30 / 255.0, 220 / 255.0, 1};
constexpr LampLight kOff = {{220 / 255.0, 220 / 255.0, 220 / 255.0, 1}, 0};
constexpr LampLight kSignal = {{0, 1, 0, 1}, 3};

// How deep a cube rests in the soft contact with a disc: put there, it wakes without a jolt.
constexpr double kSinkage = 1.06e-4;  // m

enum PropIndex { kGreenDisc, kRedDisc, kCube };
enum DrawIndex { kCenterXDraw, kCenterYDraw, kSignalStep };

mjcf::Scene make_scene() {
  mjcf::Scene scene;
  scene.render_camera = mjcf::RenderCamera::kB;
  scene.props = {mjcf::disc("green_disc", DISC_RADIUS, DISC_HALF_HEIGHT, kGreen),
                 mjcf::disc("red_disc", DISC_RADIUS, DISC_HALF_HEIGHT, kRed),
                 mjcf::cube("blue_cube", CUBE_HALF_SIZE, kBlue)};
  scene.props[kGreenDisc].pos = {-0.1, -DISC_SEPARATION / 2, DISC_HALF_HEIGHT};
  scene.props[kRedDisc].pos = {-0.1, DISC_SEPARATION / 2, DISC_HALF_HEIGHT};
  scene.props[kCube].pos = {-0.1, -DISC_SEPARATION / 2, kRestingHeight};
  return scene;
}

class TimedTransfer final : public Task {
 public:
  TimedTransfer(const RegistryEntry& entry, const Params& params)
      : params_(params), scene_(make_scene()), lamp_(scene_, "signal_lamp") {
    info_ = describe(entry);
    const TimeWindow window = time_window(0, params.DELAY_STEPS);
    const int counts = 2 * params.DELAY_STEPS + 1;
    info_.candidates = counts;
    info_.guess_rate = static_cast<double>(window.end - window.start + 1) / counts;
    info_.termination = Termination::kSuccessOrFailed;
    info_.success_reward = kTimedTransferSuccessReward;
    info_.oracle_dim = 1;
    info_.oracle_is_real = true;
    info_.draws = {{"center_x", 1, false, kCenterX[0], kCenterX[1], "m", "between the discs"},
                   {"center_y", 1, false, kCenterY[0], kCenterY[1], "m", "between the discs"},
                   {"signal_step", 1, true, static_cast<double>(PRE_SIGNAL_STEPS.low),
                    static_cast<double>(PRE_SIGNAL_STEPS.high), "control steps",
                    "from which the lamp is green"}};
    info_.hidden_draw = "signal_step";
    info_.constants = constants();
    info_.reward_terms = {"reaching_reward",  "place_reward",     "is_grasped",
                          "tcp_to_cube_dist", "obj_to_goal_dist", "cube_on_red",
                          "static_reward",    "smooth_penalty",   "action_l2",
                          "delta_action_l2",  "qvel_l2"};
    info_.phases = {{"wait", "elapsed < s; white lamp"},
                    {"count", "s <= elapsed < s + " + std::to_string(window.start)},
                    {"window", "s + " + std::to_string(window.start) + " <= elapsed <= s + " +
                                   std::to_string(window.end)}};
    info_.state_fields = {{"green_disc_pose", 7, DType::kFloat32, "m", ""},
                          {"red_disc_pose", 7, DType::kFloat32, "m", ""},
                          {"cube_pose", 7, DType::kFloat32, "m", ""},
                          {"signal_on", 1, DType::kFloat32, "", "the lamp is green"},
                          {"in_window", 1, DType::kFloat32, "", "the cube may arrive"},
                          {"is_grasped", 1, DType::kFloat32, "", ""},
                          {"oracle_info", 1, DType::kFloat32, "control steps", "delay"}};
  }

  const TaskInfo& info() const override { return info_; }
  SceneSource scene() const override { return scene_source(scene_); }
  std::string document() const override { return mjcf::compose(scene_, mjcf::Detail::kFull); }

  void bind(const Bindings& bindings) override {
    engine_ = bindings;
    reward_dict_.bind(bindings, kRewardTerms);
    signal_step_ = bindings.memory->add<std::int32_t>("signal_step", 1, "control steps");
    ColumnStore& info = *bindings.outputs;
    too_early_ = info.add<std::uint8_t>("too_early", 1, "", "on red before the window");
    signal_on_ = info.add<std::uint8_t>("signal_on");
    in_window_ = info.add<std::uint8_t>("in_window");
    before_window_ = info.add<std::uint8_t>("before_window");
    past_window_ = info.add<std::uint8_t>("past_window");
    cube_on_red_ = info.add<std::uint8_t>("cube_on_red");
    cube_to_red_dist_ = info.add<float>("cube_to_red_dist", 1, "m");
    is_grasped_ = info.add<std::uint8_t>("is_grasped");
    obj_to_goal_pos_ = info.add<float>("obj_to_goal_pos", 3, "m", "red disc minus cube");
  }

  // Whatever the draw, the lamp is green from there on.
  int cue_end(int /*env*/) const override { return PRE_SIGNAL_STEPS.high; }

  // --- sampling (3.3) ---

  void reset(const Episode& episode) override {
    const int env = episode.env();
    const State& state = *engine_.state;
    const double x = episode.real(kCenterXDraw, kCenterX[0], kCenterX[1]);
    const double y = episode.real(kCenterYDraw, kCenterY[0], kCenterY[1]);
    signal_step_[env] = episode.integer(kSignalStep, PRE_SIGNAL_STEPS.low, PRE_SIGNAL_STEPS.high);
    const double green[3] = {x, y - DISC_SEPARATION / 2, DISC_HALF_HEIGHT};
    const double red[3] = {x, y + DISC_SEPARATION / 2, DISC_HALF_HEIGHT};
    const double cube[3] = {green[0], green[1], kRestingHeight - kSinkage};
    const double lamp[3] = {x + LAMP_FORWARD_OFFSET, y, 0};
    state.place_prop(env, kGreenDisc, green, mjcf::kDiscQuat.data());
    state.place_prop(env, kRedDisc, red, mjcf::kDiscQuat.data());
    state.place_prop(env, kCube, cube, kUpright);
    lamp_.place(state, env, lamp);
  }

  // --- timing (3.4) ---

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      lamp_.shine(*engine_.state, env, count(env).signal_on ? kSignal : kOff);
    }
  }

  // --- success and failure (3.5) ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const CountPhase phase = count(env);
      const Eigen::Vector3d to_red = prop_pos(env, kRedDisc) - prop_pos(env, kCube);
      const double distance = to_red.head<2>().norm();
      const bool on_red = distance < GOAL_THRESH && prop_pos(env, kCube).z() < kOnRedHeight;
      if (on_red && phase.before_window) too_early_[env] = 1;
      if (on_red && phase.in_window && too_early_[env] == 0) engine_.success[env] = 1;
      const bool too_late = phase.past_window && engine_.success[env] == 0;
      if (too_early_[env] != 0 || too_late) engine_.failed[env] = 1;

      signal_on_[env] = phase.signal_on ? 1 : 0;
      in_window_[env] = phase.in_window ? 1 : 0;
      before_window_[env] = phase.before_window ? 1 : 0;
      past_window_[env] = phase.past_window ? 1 : 0;
      cube_on_red_[env] = on_red ? 1 : 0;
      cube_to_red_dist_[env] = static_cast<float>(distance);
      is_grasped_[env] = is_grasping(*engine_.state, env, kCube) ? 1 : 0;
      RowWriter(obj_to_goal_pos_.row(env)).add(to_red);
      engine_.oracle_values[env] = static_cast<float>(params_.DELAY_STEPS);
      reward_dict_.publish(env);
    }
  }

  // --- reward (3.7) ---

  void dense_reward(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const Haste haste = measure_haste(engine_, env, FirstChange::kFromZero);
      const SmoothnessTerms smooth = smoothness(haste, kTimedTransferSmoothness);
      const Eigen::Map<const Eigen::Vector3d> tcp(engine_.state->tcp_pos.row(env));
      TransferRewardInputs in;
      in.tcp_to_cube = (prop_pos(env, kCube) - tcp).norm();
      in.cube_to_goal = (prop_pos(env, kRedDisc) - prop_pos(env, kCube)).norm();
      in.arm_speed = haste.arm_speed;
      in.smooth_penalty = smooth.penalty;
      in.count = count(env);
      in.grasped = is_grasped_[env] != 0;
      in.on_red = cube_on_red_[env] != 0;
      in.success = engine_.success[env] != 0;
      in.failed = engine_.failed[env] != 0;
      const TransferRewardTerms terms = transfer_reward(in);
      *out.row(env) = static_cast<float>(terms.reward);
      reward_dict_.note<kRewardTerms>(
          env, {terms.reaching, terms.place, in.grasped ? 1.0 : 0.0, in.tcp_to_cube,
                in.cube_to_goal, in.on_red ? 1.0 : 0.0, terms.stillness, smooth.penalty,
                smooth.action_l2, smooth.action_delta_l2, smooth.qvel_l2});
    }
  }

  // --- observation (3.6) ---

  void observe(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      RowWriter row(out.row(env));
      for (const int prop : {kGreenDisc, kRedDisc, kCube}) {
        row.add(engine_.state->prop_pos_of(env, prop), 3);
        row.add(engine_.state->prop_quat_of(env, prop), 4);
      }
      row.add(signal_on_[env]);
      row.add(in_window_[env]);
      row.add(is_grasped_[env]);
      row.add(params_.DELAY_STEPS);
    }
  }

  // --- oracle (3.8) ---

  // Waits over the red disc with the cube in the gripper, and lowers it when the time has come.
  void act(Range envs, bool blind, FloatRows actions) override {
    constexpr double kWaitHeight = 0.1;  // m, of the cube: well above the height that counts
    const State& state = *engine_.state;
    for (int env = envs.begin; env < envs.end; ++env) {
      float* action = actions.row(env);
      const Grip grip{.prop = kCube, .tool = tool_for_cube(state, env, kCube)};
      const Eigen::Vector3d red = prop_pos(env, kRedDisc);
      const int due = blind ? signal_step_[env] + guessed_count(env) : window(env).start;
      if (state.elapsed[env] + 1 >= due) {
        const Eigen::Vector3d place(red.x(), red.y(), kRestingHeight);
        if (bring(state, env, grip, place, action)) hold_tool(kGripperOpen, action);
      } else if (take(state, env, grip, action)) {
        carry(state, env, grip, {red.x(), red.y(), kWaitHeight}, action);
      }
    }
  }

  // --- overlay (common 11) ---

  void overlay(int env, Overlay& out) const override {
    constexpr double kScale = 0.7;
    OverlayPoint at{out.width - 260, 0};
    const auto write = [&](const std::string& text) {
      at.y += 30;
      out.add(OverlayText{at, text, kScale});
    };
    const CountPhase phase = count(env);
    const TimeWindow when = window(env);
    const int due = signal_step_[env] + params_.DELAY_STEPS;
    write("T-" + std::to_string(due - engine_.state->elapsed[env]));
    write(!phase.signal_on      ? "WAIT"
          : phase.before_window ? "COUNTING"
          : phase.in_window     ? "WINDOW"
                                : "LATE");
    write("window " + std::to_string(when.start) + "-" + std::to_string(when.end));
    write("delay " + std::to_string(params_.DELAY_STEPS));
    write(cube_on_red_[env] != 0 ? "ON RED" : "not on red");
  }

 private:
  static constexpr int kRewardTerms = 11;

  ConstantTable constants() const {
    ConstantTable table = {
        {"DELAY_STEPS", params_.DELAY_STEPS},
        {"TOLERANCE_FRAC", TOLERANCE_FRAC},
        {"PRE_SIGNAL_STEPS", PRE_SIGNAL_STEPS.constant()},
        {"DISC_RADIUS", DISC_RADIUS},
        {"DISC_HALF_HEIGHT", DISC_HALF_HEIGHT},
        {"CUBE_HALF_SIZE", CUBE_HALF_SIZE},
        {"GOAL_THRESH", GOAL_THRESH},
        {"LAMP_FORWARD_OFFSET", LAMP_FORWARD_OFFSET},
        {"DISC_SEPARATION", DISC_SEPARATION},
        {"HEIGHT_OFFSET", HEIGHT_OFFSET},
        {"SUCCESS_BONUS", kTimedTransferSuccessReward},
        {"FAILURE_PENALTY", FAILURE_PENALTY},
        {"ACTION_L2_COEF", kTimedTransferSmoothness.ACTION_L2_COEF},
        {"ACTION_DELTA_L2_COEF", kTimedTransferSmoothness.ACTION_DELTA_L2_COEF},
        {"QVEL_L2_COEF", kTimedTransferSmoothness.QVEL_L2_COEF},
    };
    add_lamp_constants(table);
    return table;
  }

  TimeWindow window(int env) const { return time_window(signal_step_[env], params_.DELAY_STEPS); }
  CountPhase count(int env) const {
    return count_phase(engine_.state->elapsed[env], signal_step_[env], window(env));
  }
  Eigen::Vector3d prop_pos(int env, int prop) const {
    return Eigen::Map<const Eigen::Vector3d>(engine_.state->prop_pos_of(env, prop));
  }

  // When somebody acts who has not counted: at any step up to twice the delay.
  int guessed_count(int env) const {
    RandomStream random(engine_.state->seed[env], engine_.state->episode[env], kPurposeBlindGuess);
    return random.integer(0, 2 * params_.DELAY_STEPS);
  }

  Params params_;
  TaskInfo info_;
  mjcf::Scene scene_;
  Lamp lamp_;
  Bindings engine_;
  RewardDict reward_dict_;
  Column<std::int32_t> signal_step_;
  Column<std::uint8_t> too_early_;
  Column<std::uint8_t> signal_on_;
  Column<std::uint8_t> in_window_;
  Column<std::uint8_t> before_window_;
  Column<std::uint8_t> past_window_;
  Column<std::uint8_t> cube_on_red_;
  Column<float> cube_to_red_dist_;  // m
  Column<std::uint8_t> is_grasped_;
  Column<float> obj_to_goal_pos_;  // (3) m
};

}  // namespace

std::unique_ptr<Task> make_timed_transfer(const RegistryEntry& entry) {
  return std::make_unique<TimedTransfer>(entry, find_variant(kVariants, entry.id));
}

}  // namespace engram::tasks
