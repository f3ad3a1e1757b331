#include "tasks/trace_shape/single.h"

#include <string>

#include "tasks/common/family_base.h"
#include "tasks/common/reward_dict.h"
#include "tasks/common/variant.h"
#include "tasks/trace_shape/annotator.h"
#include "tasks/trace_shape/chance.h"
#include "tasks/trace_shape/demo.h"
#include "tasks/trace_shape/expert.h"
#include "tasks/trace_shape/info.h"
#include "tasks/trace_shape/map.h"
#include "tasks/trace_shape/params.h"
#include "tasks/trace_shape/rewards.h"
#include "tasks/trace_shape/trail.h"

namespace engram::tasks {
namespace {

class TraceShape final : public FamilyBase {
 public:
  TraceShape(const RegistryEntry& entry, const TraceParams& params)
      : FamilyBase(entry),
        params_(params),
        demo_(scene_, info_, params),
        map_(params.farthest_corner()),
        expert_(engine_, demo_, visited_),
        annotator_({.engine = engine_, .demo = demo_, .visited = visited_}) {
    info_.candidates = params.AVAILABLE_SHAPES.size();
    describe_guess(params, info_);
    info_.termination = Termination::kSuccess;
    info_.success_reward = kTraceShapeSuccessReward;
    info_.oracle_dim = 1;
    info_.answer =
        "once the cube's trail has passed for a shape: that of the available ones, as large and "
        "turned as the one that was shown, to whose checkpoints it has come nearest; its id";
    info_.answer_rate = answer_rate(params);
    info_.hidden_variable = hidden_variable(params);
    info_.reward_terms = reward_terms_of(TraceReward{});
    info_.phases = trace_phases("P + " + std::to_string(params.contours.NUM_WAYPOINTS));
    declare_state(*this);
    declare_sampled_values(*this);
  }

  void bind(const Bindings& bindings) override {
    FamilyBase::bind(bindings);
    demo_.bind(bindings);
    trail_.bind(*bindings.memory, demo_);
    expert_.bind(*bindings.memory);
    map_.bind(*bindings.memory);
    reward_dict_.bind(bindings, info_.reward_terms.size());
    visited_ = bindings.memory->add<std::int32_t>("visited", 1, "", "bits of checkpoints");
    bindings.memory->limit("visited", 0, demo_.contours().all_visited());
    masks_.bind(*bindings.outputs);
    ColumnStore& info = *bindings.outputs;
    visit_fraction_ = info.add_privileged<float>("visit_fraction", 1, "", "of the checkpoints");
    all_visited_ = info.add_privileged<std::uint8_t>("all_visited");
    is_contour_closed_ = info.add<std::uint8_t>("is_contour_closed");
    start_checkpoint_dist_ = info.add_privileged<float>("start_checkpoint_dist", 1, "m");
    checkpoint_visited_ =
        info.add_privileged<std::uint8_t>("checkpoint_visited", params_.contours.NUM_CHECKPOINTS);
    obj_to_goal_pos_ =
        info.add_privileged<float>("obj_to_goal_pos", 3, "m", "green cube minus TCP position");
  }

  int cue_end(int env) const override { return demo_.demo_end(env); }
  void sampled_values(int env, float* out) const override { write_sampled_values(*this, env, out); }
  template <class Visitor>
  void sampled_row(Visitor& row, int env) const {
    row.field("cue_steps_per_env", 1, "control steps", "until the demonstration is over",
              [&] { return demo_.demo_end(env); });
    row.field("shape_type", 1, "", "id of the shape", [&] { return *demo_.shapes(env); });
    demo_.list_waypoints(row, env);
  }

  // --- sampling ---

  void reset(const Episode& episode) override { demo_.reset(episode); }

  // --- phases ---

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) demo_.advance(env);
  }

  // --- success ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const Contour contour = demo_.contour(env, 0);
      const Vec2 green = demo_.green_at(env);
      if (demo_.is_acting(env)) {
        visited_[env] = visit(contour, green, visited_[env]);
        note_answer(env);
        expert_.follow_guess(env, green);
        map_.note(env, green);
      }
      const bool closed = is_closed(contour, green, visited_[env]);
      engine_.success[env] = closed && demo_.is_acting(env) ? 1 : 0;
      engine_.oracle_info[env] = contour.shape();

      masks_.show(env, demo_.phase(env));
      visit_fraction_[env] = static_cast<float>(demo_.contours().visited_fraction(visited_[env]));
      all_visited_[env] = visited_[env] == demo_.contours().all_visited() ? 1 : 0;
      is_contour_closed_[env] = closed ? 1 : 0;
      start_checkpoint_dist_[env] = static_cast<float>((contour.checkpoint(0) - green).norm());
      for (int i = 0; i < params_.contours.NUM_CHECKPOINTS; ++i) {
        checkpoint_visited_.row(env)[i] = static_cast<std::uint8_t>(visited_[env] >> i & 1);
      }
      RowWriter(obj_to_goal_pos_.row(env)).add(cube_from_tcp(env));
      reward_dict_.publish(env);
    }
  }

  // --- reward ---

  void dense_reward(Range envs, FloatRows out) override {
    reward_dict_.write(envs, out, [&](int env) {
      const Contour contour = demo_.contour(env, 0);
      const Vec2 green = demo_.green_at(env);
      const int nearest = nearest_checkpoint(contour, green, visited_[env]);
      return TraceReward{.tcp_to_cube = cube_from_tcp(env).norm(),
                         .acting = demo_.is_acting(env),
                         .visit_fraction = demo_.contours().visited_fraction(visited_[env]),
                         .all_visited = visited_[env] == demo_.contours().all_visited(),
                         .start_distance = (contour.checkpoint(0) - green).norm(),
                         .nearest_unvisited = (contour.checkpoint(nearest) - green).norm(),
                         .action_cost = measure_action_cost(engine_, env, FirstChange::kFromZero),
                         .success = engine_.success[env] != 0,
                         .smoothness = params_.smoothness};
    });
  }

  // --- observation ---

  template <class Visitor>
  void state_row(Visitor& row, int env) const {
    demo_.list_cubes(row, env);
    row.field("action_mask", 1, "", "the action phase", [&] { return demo_.is_acting(env); });
    row.field("visit_fraction", 1, "", "of the checkpoints",
              [&] { return demo_.contours().visited_fraction(visited_[env]); });
    row.field("oracle_info", 1, "", "id of the shape", [&] { return demo_.shapes(env)[0]; });
  }
  void observe(Range envs, FloatRows out) override { write_state(*this, envs, out); }

  // --- expert ---

  const Expert& expert() const override { return expert_; }
  const Annotator* annotator() const override { return &annotator_; }

  // --- overlay ---

  void overlay(int env, Overlay& out) const override {
    map_.draw(env, demo_.contour(env, 0), visited_[env], demo_.green_at(env), out);
    map_.caption(demo_.contour(env, 0), visited_[env], demo_.phase(env),
                 is_contour_closed_[env] != 0, out);
  }

 private:
  Eigen::Vector3d cube_from_tcp(int env) const {
    return prop_pos(env, demo_.green_cube()) - tcp_pos(env);
  }

  void note_answer(int env) const {
    const int shape = trail_.follow(env, demo_, 0);
    if (shape >= 0) engine_.answers.give(env, shape, shape == demo_.shapes(env)[0]);
  }

  TraceParams params_;
  TraceDemo demo_;
  Trail trail_;
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
  TraceShapeExpert expert_;
  TraceAnnotator annotator_;
};

}  // namespace

constexpr auto kTraceRows = rows_of(kTraceVariants);

const Family kTraceShape = {
    .name = "TraceShape",
    .memory_type = "Procedural",
    .instruction =
        "Watch the red cube trace a shape on the table. When the lamp turns green, pick up the "
        "green cube and trace exactly the same shape.",
    .tasks = kTraceRows,
    .make = make_variant<TraceShape, kTraceVariants>,
    .expectations = {.min_reward = -0.0017, .max_reward = 0.2667, .hides = true},
    .memory = {.irrelevant = CounterfactualChange::kDraw, .irrelevant_draw = "pre_demo_steps"}};

}  // namespace engram::tasks
