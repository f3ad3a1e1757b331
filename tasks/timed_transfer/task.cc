#include "tasks/timed_transfer/task.h"

#include <algorithm>
#include <array>
#include <string>

#include "core/base/error.h"
#include "core/image/overlay.h"
#include "mjcf/disc.h"
#include "mjcf/scene.h"
#include "tasks/common/family_base.h"
#include "tasks/common/lamp.h"
#include "tasks/common/layout.h"
#include "tasks/common/phase_budget.h"
#include "tasks/common/random_variables.h"
#include "tasks/common/reward_dict.h"
#include "tasks/common/task_info.h"
#include "tasks/common/task_options.h"
#include "tasks/common/variant.h"
#include "tasks/timed_transfer/annotator.h"
#include "tasks/timed_transfer/expert.h"
#include "tasks/timed_transfer/reward.h"

namespace engram::tasks {
namespace {

// --- parameters ---

struct Params {
  TaskSpec task;
  int DELAY_STEPS;
  double TOLERANCE_FRAC = tasks::TOLERANCE_FRAC;  // of the delay
  StepRange PRE_SIGNAL_STEPS{1, 3};
  double DISC_RADIUS = 0.07;  // m
  double GOAL_THRESH = 0.05;  // m
  SmoothnessParams smoothness = kTimedTransferSmoothness;

  void declare(ConstantBinder& constants);
  void check(int horizon) const;
  TimeWindow window(int signal_step, WindowRounding rounding = WindowRounding::kInward) const {
    return time_window(signal_step, DELAY_STEPS, TOLERANCE_FRAC, rounding);
  }
};

#define INSTRUCTION(steps)                                                                  \
  "When the white lamp turns green, start counting steps from that exact moment. Move the " \
  "blue cube from the green disc to the red disc exactly on step " #steps " of that count."

constexpr std::array<Params, 6> kVariants = {{
    {{.id = "TimedTransferEasy-Long-VLA-v0",
      .horizon = 600,
      .split = Split::kMedium,
      .instruction = INSTRUCTION(300)},
     300},
    {{.id = "TimedTransferEasy-VLA-v0",
      .horizon = 200,
      .split = Split::kShort,
      .instruction = INSTRUCTION(100)},
     100},
    {{.id = "TimedTransferHard-Long-VLA-v0",
      .horizon = 1200,
      .split = Split::kLong,
      .instruction = INSTRUCTION(1000)},
     1000},
    {{.id = "TimedTransferHard-VLA-v0",
      .horizon = 300,
      .split = Split::kMedium,
      .instruction = INSTRUCTION(200)},
     200},
    {{.id = "TimedTransferMedium-Long-VLA-v0",
      .horizon = 900,
      .split = Split::kLong,
      .instruction = INSTRUCTION(500)},
     500},
    {{.id = "TimedTransferMedium-VLA-v0",
      .horizon = 250,
      .split = Split::kMedium,
      .instruction = INSTRUCTION(150)},
     150},
}};

#undef INSTRUCTION

constexpr double DISC_HALF_HEIGHT = 0.003;    // m
constexpr double CUBE_HALF_SIZE = 0.02;       // m
constexpr double LAMP_FORWARD_OFFSET = 0.22;  // m
constexpr double DISC_SEPARATION = 0.22;      // m
constexpr double HEIGHT_OFFSET = 1000.0;
constexpr double kRestingHeight = 2 * DISC_HALF_HEIGHT + CUBE_HALF_SIZE;    // m, on a disc
constexpr double kOnRedHeight = 2 * DISC_HALF_HEIGHT + 3 * CUBE_HALF_SIZE;  // m

constexpr mjcf::Rgba kGreen = {30 / 255.0, 180 / 255.0, 30 / 255.0, 1};
constexpr mjcf::Rgba kRed = {200 / 255.0, 30 / 255.0, 30 / 255.0, 1};
constexpr mjcf::Rgba kBlue = {30 / 255.0, 30 / 255.0, 220 / 255.0, 1};
constexpr LampLight kOff = {{220 / 255.0, 220 / 255.0, 220 / 255.0, 1}, 0};
constexpr LampLight kSignal = {{0, 1, 0, 1}, 3};

constexpr int kTimeToCarry = 60;  // control steps until a cube waits over the red disc

void Params::declare(ConstantBinder& constants) {
  constants.integer("DELAY_STEPS", DELAY_STEPS, {60, 100'000}, "control steps",
                    "delay to be counted from the signal on; the instruction names it");
  constants.real("TOLERANCE_FRAC", TOLERANCE_FRAC, {0, 0.5}, "of the delay",
                 "how much too early or too late the cube may arrive");
  constants.steps("PRE_SIGNAL_STEPS", PRE_SIGNAL_STEPS, kPhaseSteps, "time before the signal",
                  {"signal_step", "from which the lamp is green"});
  constants.real("DISC_RADIUS", DISC_RADIUS, {0.03, 0.1}, "m", "of both discs, 0.22 m apart");
  constants.fixed({{"DISC_HALF_HEIGHT", DISC_HALF_HEIGHT}, {"CUBE_HALF_SIZE", CUBE_HALF_SIZE}});
  constants.real("GOAL_THRESH", GOAL_THRESH, {0.01, 0.1}, "m",
                 "how near the red disc's centre the cube has to be");
  constants.fixed({{"LAMP_FORWARD_OFFSET", LAMP_FORWARD_OFFSET},
                   {"DISC_SEPARATION", DISC_SEPARATION},
                   {"HEIGHT_OFFSET", HEIGHT_OFFSET},
                   {"SUCCESS_BONUS", kTimedTransferSuccessReward},
                   {"FAILURE_PENALTY", FAILURE_PENALTY}});
  smoothness.declare(constants);
  declare_lamp(constants);
}

// The cube has to be there before the window, and the window has to end before the episode does.
void Params::check(int horizon) const {
  const TimeWindow from_signal = window(0);
  if (from_signal.end < kTimeToCarry) {
    throw Error(Error::kInvalidArgument, "constants leave no time to act: the window ends " +
                                             std::to_string(from_signal.end) +
                                             " control steps after the signal, and to "
                                             "carry the cube takes " +
                                             std::to_string(kTimeToCarry));
  }
  check_horizon(horizon,
                {{"PRE_SIGNAL_STEPS", PRE_SIGNAL_STEPS.high},
                 {"the window's end after the signal", from_signal.end}},
                1);
}

// The text of the table, which names the table's delay.
std::string instruction_for(const RegistryEntry& entry, const Params& params) {
  std::string text(entry.instruction);
  if (entry.instruction != params.task.instruction) return text;
  const std::string before = "exactly on step ";
  const std::size_t begin = text.find(before) + before.size();
  return text.replace(begin, text.find(' ', begin) - begin, std::to_string(params.DELAY_STEPS));
}

// Props of the scene before the lamp's, each at its index.
enum PropIndex { kGreenDisc, kRedDisc, kCube };
constexpr std::size_t kDiscsAndCube = 3;

// Random variables of an episode.
struct Variables {
  Variables(RandomVariables list, const Params& params)
      : center_x(list.real("center_x", {-0.15, -0.05}, "m", "between the discs")),
        center_y(list.real("center_y", {-0.05, 0.05}, "m", "between the discs")),
        signal_step(list.of(params.PRE_SIGNAL_STEPS)) {}

  RealVariable center_x;
  RealVariable center_y;
  IntegerVariable signal_step;
};

std::vector<std::pair<std::string, std::string>> phases(const TimeWindow& window) {
  const std::string start = "s + " + std::to_string(window.start);
  return {{"wait", "elapsed < s; white lamp"},
          {"count", "s <= elapsed < " + start},
          {"window", start + " <= elapsed <= s + " + std::to_string(window.end)}};
}

void add_discs_and_cube(mjcf::Scene& scene, double radius) {
  scene.render_view = mjcf::RenderView::kTable;
  scene.props.resize(kDiscsAndCube);
  scene.props[kGreenDisc] = mjcf::disc("green_disc", radius, DISC_HALF_HEIGHT, kGreen);
  scene.props[kRedDisc] = mjcf::disc("red_disc", radius, DISC_HALF_HEIGHT, kRed);
  scene.props[kCube] = mjcf::cube("blue_cube", CUBE_HALF_SIZE, kBlue);
  scene.props[kGreenDisc].pos = {-0.1, -DISC_SEPARATION / 2, DISC_HALF_HEIGHT};
  scene.props[kRedDisc].pos = {-0.1, DISC_SEPARATION / 2, DISC_HALF_HEIGHT};
  scene.props[kCube].pos = {-0.1, -DISC_SEPARATION / 2, kRestingHeight};
}

class TimedTransfer final : public FamilyBase {
 public:
  TimedTransfer(const RegistryEntry& entry, const Params& params)
      : FamilyBase(entry),
        params_(params),
        variables_(RandomVariables(info_.random_variables), params),
        truncate_window_(TaskOptions(info_.options)
                             .on_off("truncate_window",
                                     "1: ends of the window are rounded down, so it may begin "
                                     "before the tolerance",
                                     /*original=*/true)),
        expert_({.engine = engine_,
                 .signal_step = signal_step_,
                 .cube = kCube,
                 .red_disc = kRedDisc,
                 .resting_height = kRestingHeight,
                 .delay_steps = params.DELAY_STEPS,
                 .tolerance = params.TOLERANCE_FRAC,
                 .rounding = rounding_,
                 .signal_steps = params.PRE_SIGNAL_STEPS}),
        annotator_({.engine = engine_,
                    .signal_step = signal_step_,
                    .lamp = lamp_,
                    .cube = kCube,
                    .red_disc = kRedDisc,
                    .delay_steps = params.DELAY_STEPS,
                    .tolerance = params.TOLERANCE_FRAC,
                    .rounding = rounding_}) {
    add_discs_and_cube(scene_, params.DISC_RADIUS);
    lamp_ = Lamp(scene_, "signal_lamp");
    info_.candidates = 2 * params.DELAY_STEPS + 1;
    info_.instruction = instruction_for(entry, params);
    info_.answer = "the first step of the count in which the cube is on red; its number";
    info_.termination = Termination::kSuccessOrFailed;
    info_.success_reward = kTimedTransferSuccessReward;
    info_.oracle_dim = 1;
    info_.oracle_is_real = true;
    info_.hidden_variable = "signal_step";
    info_.reward_terms = reward_terms_of(TransferReward{});
    describe_window();
    declare_state(*this);
    declare_sampled_values(*this);
  }

  void bind(const Bindings& bindings) override {
    FamilyBase::bind(bindings);
    reward_dict_.bind(bindings, info_.reward_terms.size());
    if (truncate_window_.is_on(bindings)) rounding_ = WindowRounding::kDown;
    describe_window();
    signal_step_ = bindings.memory->add<std::int32_t>("signal_step", 1, "control steps");
    ColumnStore& info = *bindings.outputs;
    too_early_ = info.add<std::uint8_t>("too_early", 1, "", "on red before the window");
    signal_on_ = info.add<std::uint8_t>("signal_on");
    in_window_ = info.add_privileged<std::uint8_t>("in_window");
    before_window_ = info.add_privileged<std::uint8_t>("before_window");
    past_window_ = info.add<std::uint8_t>("past_window");
    cube_on_red_ = info.add<std::uint8_t>("cube_on_red");
    cube_to_red_dist_ = info.add<float>("cube_to_red_dist", 1, "m");
    is_grasped_ = info.add<std::uint8_t>("is_grasped");
    obj_to_goal_pos_ = info.add_privileged<float>("obj_to_goal_pos", 3, "m", "red disc minus cube");
  }

  // Latest step of the signal: the lamp is green from there on.
  int cue_end(int /*env*/) const override { return params_.PRE_SIGNAL_STEPS.high; }
  void sampled_values(int env, float* out) const override { write_sampled_values(*this, env, out); }
  template <class Visitor>
  void sampled_row(Visitor& row, int env) const {
    row.field("signal_step", 1, "control steps", "when the lamp turns green",
              [&] { return signal_step_[env]; });
    row.field("window_start", 1, "control steps", "first step in which the cube may arrive",
              [&] { return window(env).start; });
    row.field("window_end", 1, "control steps", "last step in which the cube may arrive",
              [&] { return window(env).end; });
  }

  // --- sampling ---

  void reset(const Episode& episode) override {
    const int env = episode.env();
    const State& state = *engine_.state;
    const double x = variables_.center_x.sample(episode);
    const double y = variables_.center_y.sample(episode);
    signal_step_[env] = variables_.signal_step.sample(episode);
    const double green[3] = {x, y - DISC_SEPARATION / 2, DISC_HALF_HEIGHT};
    const double red[3] = {x, y + DISC_SEPARATION / 2, DISC_HALF_HEIGHT};
    const double lamp[3] = {x + LAMP_FORWARD_OFFSET, y, 0};
    state.place_prop(env, kGreenDisc, green, mjcf::kDiscQuat.data());
    state.place_prop(env, kRedDisc, red, mjcf::kDiscQuat.data());
    place_upright(state, env, kCube, {green[0], green[1]}, kRestingHeight);
    lamp_.place(state, env, lamp);
  }

  // --- phases ---

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      lamp_.shine(*engine_.state, env, count(env).signal_on ? kSignal : kOff);
    }
  }

  // --- success and failure ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const CountPhase phase = count(env);
      const Eigen::Vector3d to_red = prop_pos(env, kRedDisc) - prop_pos(env, kCube);
      const double distance = to_red.head<2>().norm();
      const bool on_red = distance < params_.GOAL_THRESH && prop_pos(env, kCube).z() < kOnRedHeight;
      if (on_red && phase.signal_on) {
        const int step = engine_.state->elapsed[env] - signal_step_[env];
        engine_.answers.give(env, step, phase.in_window);
      }
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

  // --- reward ---

  void dense_reward(Range envs, FloatRows out) override {
    reward_dict_.write(envs, out, [&](int env) {
      return TransferReward{
          .tcp_to_cube = (prop_pos(env, kCube) - tcp_pos(env)).norm(),
          .cube_to_goal = (prop_pos(env, kRedDisc) - prop_pos(env, kCube)).norm(),
          .action_cost = measure_action_cost(engine_, env, FirstChange::kFromZero),
          .count = count(env),
          .grasped = is_grasped_[env] != 0,
          .on_red = cube_on_red_[env] != 0,
          .success = engine_.success[env] != 0,
          .failed = engine_.failed[env] != 0,
          .smoothness = params_.smoothness};
    });
  }

  // --- observation ---

  template <class Visitor>
  void state_row(Visitor& row, int env) const {
    row.field("green_disc_pose", 7, "m", "", [&] { return prop_pose(env, kGreenDisc); });
    row.field("red_disc_pose", 7, "m", "", [&] { return prop_pose(env, kRedDisc); });
    row.field("cube_pose", 7, "m", "", [&] { return prop_pose(env, kCube); });
    row.field("signal_on", 1, "", "the lamp is green", [&] { return signal_on_[env]; });
    row.field("in_window", 1, "", "the cube may arrive", [&] { return in_window_[env]; });
    row.field("is_grasped", 1, "", "", [&] { return is_grasped_[env]; });
    row.field("oracle_info", 1, "control steps", "delay", [&] { return params_.DELAY_STEPS; });
  }
  void observe(Range envs, FloatRows out) override { write_state(*this, envs, out); }

  // --- expert ---

  const Expert& expert() const override { return expert_; }
  const Annotator* annotator() const override { return &annotator_; }

  // --- overlay ---

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
  void describe_window() {
    const TimeWindow window = params_.window(0, rounding_);
    info_.guess_rate = static_cast<double>(window.end - window.start + 1) / info_.candidates;
    info_.answer_rate = info_.guess_rate;
    info_.phases = phases(window);
  }
  TimeWindow window(int env) const { return params_.window(signal_step_[env], rounding_); }
  CountPhase count(int env) const {
    return count_phase(engine_.state->elapsed[env], signal_step_[env], window(env));
  }

  Params params_;
  Variables variables_;
  TaskOption truncate_window_;
  WindowRounding rounding_ = WindowRounding::kInward;
  Lamp lamp_;
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
  TimedTransferExpert expert_;
  TimedTransferAnnotator annotator_;
};

}  // namespace

constexpr auto kRows = rows_of(kVariants);

const Family kTimedTransfer = {
    .name = "TimedTransfer",
    .memory_type = "Temporal",
    .tasks = kRows,
    .make = make_variant<TimedTransfer, kVariants>,
    .expectations = {.min_reward = -0.8334, .max_reward = 0.8334},
    .memory = {
        .no_counterfactuals =
            "the signal comes in one of the first steps, and one act is right after any of them"}};

}  // namespace engram::tasks
