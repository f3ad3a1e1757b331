#include "tasks/trace_shape/single.h"

#include <array>

#include "mjcf/scene.h"
#include "tasks/parts/grasp_servo.h"
#include "tasks/parts/reward_dict.h"
#include "tasks/parts/state_row.h"
#include "tasks/parts/task_info.h"
#include "tasks/trace_shape/demo.h"
#include "tasks/trace_shape/info.h"
#include "tasks/trace_shape/map.h"
#include "tasks/trace_shape/oracle.h"
#include "tasks/trace_shape/rewards.h"

namespace engram::tasks {
namespace {

class TraceShape final : public Task {
 public:
  explicit TraceShape(const RegistryEntry& entry) : demo_(scene_, {trace_shapes_of(entry.id)}) {
    info_ = describe(entry);
    info_.candidates = trace_shapes_of(entry.id);
    info_.guess_rate = guess_rate(info_.candidates);
    info_.termination = Termination::kSuccess;
    info_.success_reward = kTraceShapeSuccessReward;
    info_.oracle_dim = 1;
    info_.draws = demo_.draws();
    info_.hidden_draw = info_.candidates > 1 ? "shape" : "radius";
    info_.constants = demo_.constants();
    add_trace_constants(kTraceShapeSuccessReward, info_.constants);
    info_.reward_terms = {"reaching_reward",   "is_grasping",          "visit_fraction",
                          "nearest_cp_reward", "closure_reward",       "smooth_penalty",
                          "tcp_to_cube_dist",  "start_checkpoint_dist"};
    info_.phases = trace_phases("P + 64");
    info_.state_fields = {{"red_cube_pose", 7, DType::kFloat32, "m", ""},
                          {"green_cube_pose", 7, DType::kFloat32, "m", ""},
                          {"action_mask", 1, DType::kFloat32, "", "the action phase"},
                          {"visit_fraction", 1, DType::kFloat32, "", "of the checkpoints"},
                          {"oracle_info", 1, DType::kFloat32, "", "id of the shape"}};
  }

  const TaskInfo& info() const override { return info_; }
  SceneSource scene() const override { return scene_source(scene_); }
  std::string document() const override { return mjcf::compose(scene_, mjcf::Detail::kFull); }

  void bind(const Bindings& bindings) override {
    engine_ = bindings;
    demo_.bind(bindings);
    guess_.bind(*bindings.memory);
    map_.bind(*bindings.memory);
    reward_dict_.bind(bindings, kRewardTerms);
    visited_ = bindings.memory->add<std::int32_t>("visited", 1, "", "bits of checkpoints");
    bindings.memory->limit("visited", 0, kAllVisited);
    masks_.bind(*bindings.outputs);
    ColumnStore& info = *bindings.outputs;
    visit_fraction_ = info.add<float>("visit_fraction", 1, "", "of the checkpoints");
    all_visited_ = info.add<std::uint8_t>("all_visited");
    is_contour_closed_ = info.add<std::uint8_t>("is_contour_closed");
    start_checkpoint_dist_ = info.add<float>("start_checkpoint_dist", 1, "m");
    checkpoint_visited_ = info.add<std::uint8_t>("checkpoint_visited", NUM_CHECKPOINTS);
    obj_to_goal_pos_ = info.add<float>("obj_to_goal_pos", 3, "m", "green cube minus TCP position");
  }

  int cue_end(int env) const override { return demo_.demo_end(env); }

  void reset(const Episode& episode) override { demo_.reset(episode); }
  void before_physics(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) demo_.before_physics(env);
  }
  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) demo_.advance(env);
  }

  // --- success (1.6) ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const Contour contour = demo_.contour(env, 0);
      const Vec2 green = demo_.green_at(env);
      if (demo_.is_acting(env)) {
        visited_[env] = visit(contour, green, visited_[env]);
        follow_guess(env, green);
        map_.note(env, green);
      }
      const bool closed = is_closed(contour, green, visited_[env]);
      engine_.success[env] = closed && demo_.is_acting(env) ? 1 : 0;
      engine_.oracle_info[env] = contour.shape();

      masks_.show(env, demo_.phase(env));
      visit_fraction_[env] = static_cast<float>(visited_fraction(env));
      all_visited_[env] = visited_[env] == kAllVisited ? 1 : 0;
      is_contour_closed_[env] = closed ? 1 : 0;
      start_checkpoint_dist_[env] = static_cast<float>((contour.checkpoint(0) - green).norm());
      for (int i = 0; i < NUM_CHECKPOINTS; ++i) {
        checkpoint_visited_.row(env)[i] = static_cast<std::uint8_t>(visited_[env] >> i & 1);
      }
      RowWriter(obj_to_goal_pos_.row(env)).add(cube_from_tcp(env));
      reward_dict_.publish(env);
    }
  }

  // --- reward (1.8) ---

  void dense_reward(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const Contour contour = demo_.contour(env, 0);
      const Vec2 green = demo_.green_at(env);
      const int nearest = nearest_checkpoint(contour, green, visited_[env]);
      const Haste haste = measure_haste(engine_, env, FirstChange::kFromZero);
      TraceRewardInputs in;
      in.tcp_to_cube = cube_from_tcp(env).norm();
      in.acting = demo_.is_acting(env);
      in.visit_fraction = visited_fraction(env);
      in.all_visited = visited_[env] == kAllVisited;
      in.start_distance = (contour.checkpoint(0) - green).norm();
      in.nearest_unvisited = (contour.checkpoint(nearest) - green).norm();
      in.smooth_penalty = smoothness(haste, kTraceSmoothness).penalty;
      in.success = engine_.success[env] != 0;
      const TraceRewardTerms terms = trace_reward(in);
      *out.row(env) = static_cast<float>(terms.reward);
      reward_dict_.note<kRewardTerms>(
          env, {terms.reaching, terms.grasping, in.visit_fraction, terms.nearest, terms.closure,
                in.smooth_penalty, in.tcp_to_cube, in.start_distance});
    }
  }

  // --- observation (1.7) ---

  void observe(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      RowWriter row(out.row(env));
      for (const int cube : {demo_.red_cube(), demo_.green_cube()}) {
        row.add(engine_.state->prop_pos_of(env, cube), 3);
        row.add(engine_.state->prop_quat_of(env, cube), 4);
      }
      row.add(demo_.is_acting(env) ? 1 : 0);
      row.add(visited_fraction(env));
      row.add(demo_.shapes(env)[0]);
    }
  }

  // --- oracle (1.9) ---

  void act(Range envs, bool blind, FloatRows actions) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      float* action = actions.row(env);
      if (!demo_.is_acting(env)) {
        await_demo(action);
      } else if (blind) {
        trace_contour(*engine_.state, env, demo_.green_cube(), demo_.guessed_contour(env, 0),
                      guess_.visited[env], action);
      } else {
        trace_contour(*engine_.state, env, demo_.green_cube(), demo_.contour(env, 0), visited_[env],
                      action);
      }
    }
  }

  // --- overlay (common 11) ---

  void overlay(int env, Overlay& out) const override {
    map_.draw(env, demo_.contour(env, 0), visited_[env], demo_.green_at(env), out);
    map_.caption(demo_.contour(env, 0), visited_[env], demo_.phase(env),
                 is_contour_closed_[env] != 0, out);
  }

 private:
  static constexpr int kRewardTerms = 8;

  // Measured over 2000 episodes: how often a guess of shape, radius and rotation passes near enough
  // to every checkpoint, by the number of shapes to choose from.
  static double guess_rate(int shapes) {
    constexpr std::array<double, 4> kRates = {0, 0.785, 0.535, 0.34};
    return kRates[static_cast<std::size_t>(shapes)];
  }

  double visited_fraction(int env) const {
    return static_cast<double>(count_visits(visited_[env])) / NUM_CHECKPOINTS;
  }
  Eigen::Vector3d cube_from_tcp(int env) const {
    const State& state = *engine_.state;
    return Eigen::Map<const Eigen::Vector3d>(state.prop_pos_of(env, demo_.green_cube())) -
           Eigen::Map<const Eigen::Vector3d>(state.tcp_pos.row(env));
  }

  // Round after round, for as long as the episode lasts.
  void follow_guess(int env, const Vec2& green) const {
    const Contour contour = demo_.guessed_contour(env, 0);
    std::int32_t& visited = guess_.visited[env];
    visited = visit(contour, green, visited);
    if (is_closed(contour, green, visited)) visited = 0;
  }

  TaskInfo info_;
  mjcf::Scene scene_;
  TraceDemo demo_;
  Bindings engine_;
  GuessedTrace guess_;
  TraceMap map_;
  RewardDict reward_dict_;
  TraceMasks masks_;
  Column<std::int32_t> visited_;
  Column<float> visit_fraction_;
  Column<std::uint8_t> all_visited_;
  Column<std::uint8_t> is_contour_closed_;
  Column<float> start_checkpoint_dist_;
  Column<std::uint8_t> checkpoint_visited_;  // (NUM_CHECKPOINTS)
  Column<float> obj_to_goal_pos_;            // (3) m
};

}  // namespace

std::unique_ptr<Task> make_trace_shape(const RegistryEntry& entry) {
  return std::make_unique<TraceShape>(entry);
}

}  // namespace engram::tasks
