#include "tasks/gather_and_recall/task.h"

#include <algorithm>
#include <array>
#include <string>

#include "core/base/index.h"
#include "mjcf/disc.h"
#include "mjcf/scene.h"
#include "tasks/common/family_base.h"
#include "tasks/common/lamp.h"
#include "tasks/common/press_button.h"
#include "tasks/common/reward_dict.h"
#include "tasks/common/variant.h"
#include "tasks/gather_and_recall/annotator.h"
#include "tasks/gather_and_recall/expert.h"
#include "tasks/gather_and_recall/params.h"
#include "tasks/gather_and_recall/reward.h"

namespace engram::tasks {
namespace {

// Parameters: tasks/gather_and_recall/params.h.
class GatherAndRecall final : public FamilyBase {
 public:
  GatherAndRecall(const RegistryEntry& entry, const GatherParams& params)
      : FamilyBase(entry),
        params_(params),
        variables_(RandomVariables(info_.random_variables), params),
        cubes_(params.N_CUBES),
        disc_(add_cubes_and_disc(scene_, params)),
        buttons_{PressButton(scene_, "button_red", gather_button(0)),
                 PressButton(scene_, "button_green", gather_button(1)),
                 PressButton(scene_, "button_blue", gather_button(2))},
        lamp_(scene_, "lamp"),
        expert_({.engine = engine_,
                 .params = params_,
                 .buttons = buttons_,
                 .disc = disc_xy_,
                 .flash_color = flash_color_,
                 .flash_active = flash_active_,
                 .flash_triggered = flash_triggered_,
                 .pressed_button = pressed_button_}),
        annotator_({.engine = engine_,
                    .params = params_,
                    .buttons = buttons_,
                    .flash_color = flash_color_,
                    .flash_triggered = flash_triggered_,
                    .on_disc = sticky_,
                    .n_on_disc = n_on_disc_,
                    .all_on_disc = all_on_disc_}) {
    describe_gather(info_);
    info_.reward_terms = reward_terms_of(GatherReward{});
    declare_state(*this);
    declare_sampled_values(*this);
  }

  void bind(const Bindings& bindings) override {
    FamilyBase::bind(bindings);
    ColumnStore& memory = *bindings.memory;
    for (PressButton& button : buttons_) button.bind(bindings);
    reward_dict_.bind(bindings, info_.reward_terms.size());
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

  void sampled_values(int env, float* out) const override { write_sampled_values(*this, env, out); }
  template <class Visitor>
  void sampled_row(Visitor& row, int env) const {
    row.field("flash_trigger_count", 1, "", "cubes on the disc at which the lamp flashes",
              [&] { return trigger_count_[env]; });
    row.field("flash_duration", 1, "control steps", "length of the flash",
              [&] { return duration_[env]; });
    row.field("flash_color", 1, "", "colour of the flash", [&] { return flash_color_[env]; });
  }

  // --- sampling ---

  void reset(const Episode& episode) override {
    const int env = episode.env();
    flash_color_[env] = variables_.flash_color.sample(episode);
    trigger_count_[env] = variables_.trigger_count.sample(episode);
    duration_[env] = variables_.duration.sample(episode);
    const Vec2 disc(variables_.disc_x.sample(episode), variables_.disc_y.sample(episode));
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

  // --- phases: cubes on the disc, flash and buttons ---

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      count_cubes(env);
      Flash flash{flash_triggered_[env] != 0, flash_start_[env]};
      const bool lit = update_flash(flash, n_on_disc_[env], trigger_count_[env], duration_[env],
                                    engine_.state->elapsed[env]);
      flash_triggered_[env] = flash.triggered ? 1 : 0;
      flash_start_[env] = flash.start;
      flash_active_[env] = lit ? 1 : 0;
      lamp_.shine(*engine_.state, env,
                  lit ? LampLight{FLASH_COLORS[at(flash_color_[env])], kFlashEmission}
                      : LampLight{kBulbOff, 0});
      for (const PressButton& button : buttons_) button.follow_tool(env, true);
    }
  }

  // --- success and failure ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const bool all = all_on_disc_[env] != 0;
      for (int color = 0; color < kColors; ++color) {
        const bool counts = all && pressed_button_[env] < 0 && button(color).pressed(env);
        if (!counts) continue;
        pressed_button_[env] = color;
        engine_.answers.give(env, color, color == flash_color_[env]);
      }
      const bool pressed = pressed_button_[env] >= 0;
      const bool correct = pressed_button_[env] == flash_color_[env];
      was_correct_[env] |= pressed && correct && all ? 1 : 0;
      has_failed_[env] |= pressed && !correct ? 1 : 0;
      engine_.success[env] = was_correct_[env] != 0 && all ? 1 : 0;
      engine_.failed[env] = has_failed_[env];
      engine_.oracle_info[env] = flash_color_[env];
      shown_color_[env] = flash_color_[env];
      update_goal(env);
      reward_dict_.publish(env);
    }
  }

  // --- reward ---

  void dense_reward(Range envs, FloatRows out) override {
    reward_dict_.write(envs, out, [&](int env) {
      return GatherReward{.goal_distance = Eigen::Map<const Eigen::Vector3d>(goal_.row(env)).norm(),
                          .cubes = cubes_,
                          .cubes_on_disc = n_on_disc_[env],
                          .all_on_disc = all_on_disc_[env] != 0,
                          .correct_depth = button(flash_color_[env]).press_fraction(env),
                          .action_cost = measure_action_cost(engine_, env, FirstChange::kFromZero),
                          .failed = engine_.failed[env] != 0,
                          .success = engine_.success[env] != 0,
                          .smoothness = params_.smoothness};
    });
  }

  // --- observation ---

  template <class Visitor>
  void state_row(Visitor& row, int env) const {
    row.field("obj_to_goal_pos", 3, "m", "next goal minus TCP position",
              [&] { return static_cast<const double*>(goal_.row(env)); });
    row.field("oracle_info", 1, "", "colour of the flash", [&] { return flash_color_[env]; });
    row.field("disc_pose", 7, "m", "", [&] { return prop_pose(env, disc_); });
    row.field("cubes_on_disc", cubes_, "", "has been on the disc",
              [&] { return sticky_.row(env); });
    row.field("n_on_disc", 1, "", "cubes that have been on the disc",
              [&] { return n_on_disc_[env]; });
    row.field("all_on_disc", 1, "", "all of them are, and rest", [&] { return all_on_disc_[env]; });
    row.field("flash_active", 1, "", "", [&] { return flash_active_[env]; });
    row.field("flash_color", 1, "", "", [&] { return flash_color_[env]; });
    row.field("pressed_button", 1, "", "-1: none", [&] { return pressed_button_[env]; });
    for (int cube = 0; cube < cubes_; ++cube) {
      row.field(NumberedName{"cube_", cube, "_pose"}, 7, "m", "",
                [&] { return prop_pose(env, cube); });
    }
  }
  void observe(Range envs, FloatRows out) override { write_state(*this, envs, out); }

  // --- expert ---

  const Expert& expert() const override { return expert_; }
  const Annotator* annotator() const override { return &annotator_; }

 private:
  // Returns the index of the disc's prop.
  static int add_cubes_and_disc(mjcf::Scene& scene, const GatherParams& params) {
    const int cubes = params.N_CUBES;
    scene.render_view = mjcf::RenderView::kTable;
    const Vec2 disc((DISC_X_MIN + DISC_X_MAX) / 2, (DISC_Y_MIN + DISC_Y_MAX) / 2);
    for (int cube = 0; cube < cubes; ++cube) {
      scene.props.push_back(mjcf::cube("gather_cube_" + std::to_string(cube), CUBE_HALF_SIZE,
                                       FLASH_COLORS[at(cube % kColors)]));
      const Vec2 place = cluster_place(cube, cubes, CUBE_HALF_SIZE, disc);
      scene.props.back().pos = {place.x(), place.y(), CUBE_HALF_SIZE};
    }
    scene.props.push_back(
        mjcf::disc("target_disc", params.DISC_RADIUS, DISC_HALF_HEIGHT, kDiscColor));
    return cubes;
  }

  void bind_info(ColumnStore& info) {
    n_on_disc_ = info.add<std::int32_t>("n_on_disc", 1, "", "cubes that have been on the disc");
    all_on_disc_ = info.add<std::uint8_t>("all_on_disc", 1, "", "all of them are, and rest");
    flash_active_ = info.add<std::uint8_t>("flash_active");
    flash_triggered_ = info.add<std::uint8_t>("flash_triggered");
    shown_color_ = info.add_privileged<std::int32_t>("flash_color");
    pressed_button_ = info.add<std::int32_t>("pressed_button", 1, "", "-1: none");
    info.limit("pressed_button", -1, kColors - 1);
    obj_to_goal_pos_ =
        info.add_privileged<float>("obj_to_goal_pos", 3, "m", "next goal minus TCP position");
  }

  const PressButton& button(int color) const { return buttons_[at(color)]; }
  Vec2 disc(int env) const { return Eigen::Map<const Vec2>(disc_xy_.row(env)); }
  void place_cubes(const Episode& episode, const Vec2& disc) const {
    const double* pinned = variables_.cube_jitter.pinned(episode);
    RandomStream random = variables_.cube_jitter.stream(episode);
    for (int cube = 0; cube < cubes_; ++cube) {
      Vec2 place = cluster_place(cube, cubes_, CUBE_HALF_SIZE, disc);
      for (int i = 0; i < 2; ++i) {
        place[i] += pinned != nullptr ? pinned[2 * cube + i] : random.uniform(-kJitter, kJitter);
      }
      place_upright(*engine_.state, episode.env(), cube, place, CUBE_HALF_SIZE);
    }
  }

  void count_cubes(int env) const {
    int sticky = 0;
    bool all = true;
    for (int cube = 0; cube < cubes_; ++cube) {
      const Eigen::Map<const Eigen::Vector3d> velocity(engine_.state->prop_qvel_of(env, cube));
      const bool on = is_on_disc(prop_pos(env, cube), velocity, disc(env), params_.DISC_ON_THRESH);
      now_on_disc_.row(env)[cube] = on ? 1 : 0;
      sticky_.row(env)[cube] |= on ? 1 : 0;
      sticky += sticky_.row(env)[cube];
      all = all && on;
    }
    n_on_disc_[env] = sticky;
    all_on_disc_[env] = all ? 1 : 0;
  }

  // Goal vector: to a cube that is still to be moved, to the disc while one is held, and to the
  // button at last.
  void update_goal(int env) const {
    Eigen::Map<Eigen::Vector3d> goal(goal_.row(env));
    goal.setZero();
    if (all_on_disc_[env] != 0) {
      if (pressed_button_[env] < 0) goal = button(flash_color_[env]).above(env) - tcp_pos(env);
    } else if (const int cube = nearest_unplaced(env); cube >= 0) {
      goal = prop_pos(env, cube) - tcp_pos(env);
      if (goal.norm() < GRASP_THRESH) {
        goal = Eigen::Vector3d(disc(env).x(), disc(env).y(), kOnDisc) - tcp_pos(env);
      }
    }
    RowWriter(obj_to_goal_pos_.row(env)).add(Eigen::Vector3d(goal));
  }

  // Nearest to the TCP of the cubes that have never been on the disc; -1: none.
  int nearest_unplaced(int env) const {
    int nearest = -1;
    double least = 0;
    for (int cube = 0; cube < cubes_; ++cube) {
      if (sticky_.row(env)[cube] != 0) continue;
      const double distance = (prop_pos(env, cube) - tcp_pos(env)).norm();
      if (nearest >= 0 && distance >= least) continue;
      nearest = cube;
      least = distance;
    }
    return nearest;
  }

  GatherParams params_;
  GatherVariables variables_;
  int cubes_;
  int disc_;  // index of the prop
  std::array<PressButton, kColors> buttons_;
  Lamp lamp_;
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
  GatherExpert expert_;
  GatherAnnotator annotator_;
};

}  // namespace

constexpr auto kRows = rows_of(kGatherVariants);

const Family kGatherAndRecall = {
    .name = "GatherAndRecall",
    .memory_type = "Prospective",
    .instruction =
        "Move all cubes onto the disc. A lamp will briefly flash while you work. After all "
        "cubes are placed, press the button matching the flash color.",
    .tasks = kRows,
    .make = make_variant<GatherAndRecall, kGatherVariants>,
    .expectations = {.min_reward = -0.5, .max_reward = 0.4},
    .memory = {.irrelevant = CounterfactualChange::kDraw,
               .irrelevant_draw = "flash_duration",
               .items = "N_CUBES"}};

}  // namespace engram::tasks
