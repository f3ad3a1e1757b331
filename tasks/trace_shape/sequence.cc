#include "tasks/trace_shape/sequence.h"

#include <algorithm>
#include <array>
#include <string>

#include "core/image/overlay.h"
#include "mjcf/scene.h"
#include "tasks/common/family_base.h"
#include "tasks/common/press_button.h"
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

class TraceShapeSeq final : public FamilyBase {
 public:
  TraceShapeSeq(const RegistryEntry& entry, const TraceParams& params)
      : FamilyBase(entry),
        params_(params),
        demo_(scene_, info_, params),
        button_(scene_, "trace_shape_seq_button", kSubmitButton),
        map_(params.farthest_corner()),
        expert_({.engine = engine_,
                 .info = info_,
                 .demo = demo_,
                 .button = button_,
                 .active = active_,
                 .visited = visited_,
                 .closed = closed_}),
        annotator_({.engine = engine_,
                    .demo = demo_,
                    .visited = visited_,
                    .closed = &closed_,
                    .button = &button_}) {
    info_.candidates = count_sequences(params);
    describe_guess(params, info_);
    info_.termination = Termination::kSuccessOrFailed;
    info_.success_reward = kTraceShapeSeqSuccessReward;
    info_.oracle_dim = params.MAX_SEQUENCE_LENGTH;
    info_.answer =
        "at the submission, or at the first contour that passes for another shape than the one "
        "that is due: the shapes so far, a digit each, id + 1";
    info_.answer_rate = answer_rate(params);
    info_.hidden_variable = hidden_variable(params);
    info_.reward_terms = reward_terms_of(TraceSeqReward{});
    info_.phases = trace_phases("P + " + std::to_string(params.contours.NUM_WAYPOINTS) + " L");
    declare_state(*this);
    declare_sampled_values(*this);
  }

  void bind(const Bindings& bindings) override {
    FamilyBase::bind(bindings);
    ColumnStore& memory = *bindings.memory;
    demo_.bind(bindings);
    button_.bind(bindings);
    trail_.bind(memory, demo_);
    expert_.bind(memory);
    map_.bind(memory);
    reward_dict_.bind(bindings, info_.reward_terms.size());
    active_ = memory.add<std::int32_t>("active");
    visited_ = memory.add<std::int32_t>("visited", 1, "", "bits of the active checkpoints");
    closed_ = memory.add<std::int32_t>("closed", 1, "", "closed contours");
    given_ = memory.add<std::int32_t>("given", 1, "", "shapes that the robot has committed to");
    memory.limit("active", 0, params_.MAX_SEQUENCE_LENGTH - 1);
    memory.limit("visited", 0, demo_.contours().all_visited());
    memory.limit("closed", 0, params_.MAX_SEQUENCE_LENGTH);
    memory.limit("given", 0, 9'999'999);
    masks_.bind(*bindings.outputs);
    bind_info(*bindings.outputs);
  }

  int cue_end(int env) const override { return demo_.demo_end(env); }
  void sampled_values(int env, float* out) const override { write_sampled_values(*this, env, out); }
  template <class Visitor>
  void sampled_row(Visitor& row, int env) const {
    row.field("cue_steps_per_env", 1, "control steps", "until the demonstration is over",
              [&] { return demo_.demo_end(env); });
    row.field("sequence_len", 1, "", "number of shapes", [&] { return demo_.length(env); });
    row.field("shape_sequence", params_.MAX_SEQUENCE_LENGTH, "", "ids of the shapes, then -1",
              [&] { return demo_.shapes(env); });
    demo_.list_waypoints(row, env);
  }

  // --- sampling ---

  void reset(const Episode& episode) override {
    demo_.reset(episode);
    const Vec2 offset(BUTTON_OFFSET_FROM_LAMP_X, BUTTON_OFFSET_FROM_LAMP_Y);
    button_.reset(episode.env(), demo_.lamp_at(episode.env()) + offset);
  }

  // --- phases ---

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      demo_.advance(env);
      button_.follow_tool(env, demo_.is_acting(env));
    }
  }

  // --- success and failure: contours and their submission ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const bool acting = demo_.is_acting(env);
      if (acting) follow_cube(env, demo_.green_at(env));
      const bool complete = all_closed(env);
      const bool submitted = button_.press_once(env, acting, true);
      if (submitted) engine_.answers.give(env, given_[env], complete);
      submitted_[env] = submitted ? 1 : 0;
      successful_submit_event_[env] = submitted && complete ? 1 : 0;
      submit_success_latched_[env] |= successful_submit_event_[env];
      engine_.success[env] = submit_success_latched_[env];
      failed_submit_[env] = engine_.failed[env] = submitted && !complete ? 1 : 0;
      button_pressed_[env] |= submitted_[env];
      button_pressable_[env] = complete && acting ? 1 : 0;
      show_progress(env);
      reward_dict_.publish(env);
    }
  }

  // --- reward ---

  void dense_reward(Range envs, FloatRows out) override {
    reward_dict_.write(envs, out, [&](int env) {
      const TraceReward trace{
          .tcp_to_cube = (prop_pos(env, demo_.green_cube()) - tcp_pos(env)).norm(),
          .acting = demo_.is_acting(env),
          .visit_fraction = demo_.contours().visited_fraction(visited_[env]),
          .all_visited = visited_[env] == demo_.contours().all_visited(),
          .start_distance = (active_contour(env).checkpoint(0) - demo_.green_at(env)).norm(),
          .action_cost = measure_action_cost(engine_, env, FirstChange::kFromZero),
          .success = engine_.success[env] != 0,
          .smoothness = params_.smoothness};
      return TraceSeqReward{.trace = trace,
                            .progress = progress(env),
                            .button_awaits = button_awaits(env),
                            .button_distance = (button_.above(env) - tcp_pos(env)).norm(),
                            .press_fraction = button_.press_fraction(env),
                            .failed_submit = failed_submit_[env] != 0};
    });
  }

  // --- observation ---

  template <class Visitor>
  void state_row(Visitor& row, int env) const {
    demo_.list_cubes(row, env);
    row.field("action_mask", 1, "", "the action phase", [&] { return demo_.is_acting(env); });
    row.field("sequence_progress", 1, "", "fraction of closed contours",
              [&] { return progress(env); });
    row.field("active_shape_idx", 1, "", "of the contour to be traced",
              [&] { return active_[env]; });
    row.field("active_shape_id", 1, "", "", [&] { return active_contour(env).shape(); });
    row.field("sequence_len", 1, "", "contours in all", [&] { return demo_.length(env); });
    row.field("button_xy", 2, "m", "",
              [&](RowWriter& out) { out.add(button_.center(env).data(), 2); });
    row.field("button_pressed", 1, "", "", [&] { return button_pressed_[env]; });
    row.field("oracle_info", params_.MAX_SEQUENCE_LENGTH, "", "ids of the shapes, then -1",
              [&] { return demo_.shapes(env); });
  }
  void observe(Range envs, FloatRows out) override { write_state(*this, envs, out); }

  // --- expert ---

  const Expert& expert() const override { return expert_; }
  const Annotator* annotator() const override { return &annotator_; }

  // --- overlay ---

  void overlay(int env, Overlay& out) const override {
    const Contour contour = active_contour(env);
    map_.draw(env, contour, visited_[env], demo_.green_at(env), out);
    const OverlayPoint next = TraceMap::caption(contour, visited_[env], demo_.phase(env),
                                                is_active_contour_closed_[env] != 0, out);
    const std::string length = "/" + std::to_string(demo_.length(env));
    out.add(OverlayText{next,
                        "Seq " + std::to_string(active_[env] + 1) + length + " Done " +
                            std::to_string(closed_[env]) + length,
                        TraceMap::kTextScale});
  }

 private:
  void bind_info(ColumnStore& info) {
    failed_submit_ = info.add<std::uint8_t>("failed_submit");
    submitted_ = info.add<std::uint8_t>("submitted");
    successful_submit_event_ = info.add<std::uint8_t>("successful_submit_event");
    sequence_progress_ =
        info.add_privileged<float>("sequence_progress", 1, "", "fraction of closed contours");
    all_shapes_closed_ = info.add<std::uint8_t>("all_shapes_closed");
    active_shape_idx_ = info.add_privileged<std::int32_t>("active_shape_idx");
    active_shape_id_ = info.add_privileged<std::int32_t>("active_shape_id");
    active_visit_fraction_ = info.add_privileged<float>("active_visit_fraction");
    active_all_visited_ = info.add_privileged<std::uint8_t>("active_all_visited");
    is_active_contour_closed_ = info.add<std::uint8_t>("is_active_contour_closed");
    start_checkpoint_dist_ = info.add_privileged<float>("start_checkpoint_dist", 1, "m");
    button_pressed_ = info.add<std::uint8_t>("button_pressed");
    button_pressable_ = info.add<std::uint8_t>("button_pressable");
    button_press_depth_ = info.add<float>("button_press_depth", 1, "m");
    xy_dist_to_button_ = info.add<float>("xy_dist_to_button", 1, "m");
    submit_success_latched_ = info.add<std::uint8_t>("submit_success_latched");
    obj_to_goal_pos_ =
        info.add_privileged<float>("obj_to_goal_pos", 3, "m", "next goal minus TCP position");
    // In info only: policies must not see it.
    task_cue_ = info.add_privileged<std::int32_t>("task_cue", params_.MAX_SEQUENCE_LENGTH, "",
                                                  "ids of the shapes, then -1");
  }

  // One step of the element machine: visits count for the active contour only.
  void follow_cube(int env, const Vec2& green) const {
    map_.note(env, green);
    note_answer(env);
    const Contour contour = active_contour(env);
    visited_[env] = visit(contour, green, visited_[env]);
    if (is_closed(contour, green, visited_[env]) && !all_closed(env)) {
      trail_.forget(env);
      closed_[env] = active_[env] + 1;
      if (closed_[env] < demo_.length(env)) {
        active_[env] = closed_[env];
        visited_[env] = 0;
      }
    }
    expert_.follow_guess(env, green);
  }

  // Answers with every contour; one more than were shown is wrong, too.
  void note_answer(int env) const {
    if (engine_.answers.given(env)) return;
    const int shape = trail_.follow(env, demo_, active_[env]);
    if (shape < 0) return;
    given_[env] = 10 * given_[env] + shape + 1;
    const bool due = !all_closed(env) && shape == active_contour(env).shape();
    if (!due) engine_.answers.give(env, given_[env], false);
  }

  void show_progress(int env) const {
    const Contour contour = active_contour(env);
    const Vec2 green = demo_.green_at(env);
    masks_.show(env, demo_.phase(env));
    sequence_progress_[env] = static_cast<float>(progress(env));
    all_shapes_closed_[env] = all_closed(env) ? 1 : 0;
    active_shape_idx_[env] = active_[env];
    active_shape_id_[env] = contour.shape();
    active_visit_fraction_[env] =
        static_cast<float>(demo_.contours().visited_fraction(visited_[env]));
    active_all_visited_[env] = visited_[env] == demo_.contours().all_visited() ? 1 : 0;
    is_active_contour_closed_[env] = is_closed(contour, green, visited_[env]) ? 1 : 0;
    start_checkpoint_dist_[env] = static_cast<float>((contour.checkpoint(0) - green).norm());
    button_press_depth_[env] = static_cast<float>(button_.depth(env));
    xy_dist_to_button_[env] = static_cast<float>(button_.distance(env));
    RowWriter(obj_to_goal_pos_.row(env)).add(goal(env, contour, green) - tcp_pos(env));
    std::copy_n(demo_.shapes(env), params_.MAX_SEQUENCE_LENGTH, engine_.oracle_info.row(env));
    std::copy_n(demo_.shapes(env), params_.MAX_SEQUENCE_LENGTH, task_cue_.row(env));
  }

  Eigen::Vector3d goal(int env, const Contour& contour, const Vec2& green) const {
    if (button_awaits(env)) return button_.above(env);
    const int nearest = nearest_checkpoint(contour, green, visited_[env]);
    const Vec2 at = contour.checkpoint(nearest);
    return {at.x(), at.y(), CUBE_HALFSIZE};
  }

  Contour active_contour(int env) const { return demo_.contour(env, active_[env]); }
  bool all_closed(int env) const { return closed_[env] >= demo_.length(env); }
  double progress(int env) const { return static_cast<double>(closed_[env]) / demo_.length(env); }
  bool button_awaits(int env) const {
    return button_pressable_[env] != 0 && button_pressed_[env] == 0;
  }

  TraceParams params_;
  TraceDemo demo_;
  Trail trail_;
  PressButton button_;
  TraceMap map_;
  RewardDict reward_dict_;
  TraceMasks masks_;
  Column<std::int32_t> active_;   // contour that is to be traced
  Column<std::int32_t> visited_;  // bits of its checkpoints
  Column<std::int32_t> closed_;   // contours that are closed
  Column<std::int32_t> given_;    // shapes that were committed to: digits
  Column<std::uint8_t> failed_submit_;
  Column<std::uint8_t> submitted_;
  Column<std::uint8_t> successful_submit_event_;
  Column<float> sequence_progress_;
  Column<std::uint8_t> all_shapes_closed_;
  Column<std::int32_t> active_shape_idx_;
  Column<std::int32_t> active_shape_id_;
  Column<float> active_visit_fraction_;
  Column<std::uint8_t> active_all_visited_;
  Column<std::uint8_t> is_active_contour_closed_;
  Column<float> start_checkpoint_dist_;
  Column<std::uint8_t> button_pressed_;
  Column<std::uint8_t> button_pressable_;
  Column<float> button_press_depth_;
  Column<float> xy_dist_to_button_;
  Column<std::uint8_t> submit_success_latched_;
  Column<float> obj_to_goal_pos_;  // (3) m
  Column<std::int32_t> task_cue_;  // (MAX_SEQUENCE_LENGTH)
  TraceShapeSeqExpert expert_;
  TraceAnnotator annotator_;
};

}  // namespace

constexpr auto kTraceSeqRows = rows_of(kTraceSeqVariants);

const Family kTraceShapeSeq = {
    .name = "TraceShapeSeq",
    .memory_type = "Procedural",
    .instruction =
        "Watch the red cube trace a sequence of shapes. When the lamp turns green, pick up the "
        "green cube and trace the same sequence in order. After finishing all shapes, press "
        "the button to submit your answer.",
    .tasks = kTraceSeqRows,
    .make = make_variant<TraceShapeSeq, kTraceSeqVariants>,
    .expectations = {.min_reward = -0.05, .max_reward = 0.3575, .hides = true},
    .memory = {.answer_cut = AnswerCut::kDigits,
               .irrelevant = CounterfactualChange::kDraw,
               .irrelevant_draw = "pre_demo_steps",
               .items = "sequence_length"}};

}  // namespace engram::tasks
