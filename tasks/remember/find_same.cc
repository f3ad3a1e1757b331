#include "tasks/remember/find_same.h"

#include <array>
#include <optional>

#include "tasks/common/task_options.h"
#include "tasks/common/variant.h"
#include "tasks/remember/object_recall.h"

namespace engram::tasks {
namespace {

// --- parameters ---

using enum Vocabulary;

constexpr StepRange kShortCue{1, 5};
constexpr StepRange kShortEmpty{1, 5};
constexpr StepRange kLongCue{10, 100};
constexpr StepRange kFixedCue{100, 100};
constexpr StepRange kLongEmpty{50, 450};
constexpr StepRange kRlPhase{5, 5};  // TIME_OFFSET, delta_time
constexpr ArcParams kRound{.radius = 0.3, .compression = 0};

// Control steps from the appearance on in which objects are put back to where they appeared.
constexpr int APPEAR_SETTLE_STEPS = 3;

struct FindSameParams : ObjectRecallParams {
  // Steps in which objects are put back; cubes, and all objects of the RL tasks, in the first
  // alone.
  constexpr int settle_steps() const {
    return task.is_rl() || objects.vocabulary == kColor ? 1 : APPEAR_SETTLE_STEPS;
  }
  // The original sets the poses of cubes, to where they are, in every control step.
  constexpr bool forgets_contacts() const { return !task.is_rl() && objects.vocabulary == kColor; }
  // Three objects are spread and stretched.
  constexpr bool spreads() const { return !task.is_rl() && objects.count == 3; }

  void declare(ConstantBinder& constants) {
    ObjectRecallParams::declare(constants);
    if (settle_steps() > 1) constants.fixed({{"APPEAR_SETTLE_STEPS", APPEAR_SETTLE_STEPS}});
  }
};

// A row of the RL tasks.
constexpr FindSameParams rl_row(std::string_view id, const ObjectSetParams& objects,
                                const ArcParams& arc = {}) {
  return {{{id, 60, Split::kRl}, objects, kRlPhase, kRlPhase, arc, GOAL_THRESH, std::nullopt}};
}

constexpr std::array<FindSameParams, 9> kColors = {{
    {{{"RememberColor3-Long-VLA-v0", 600, Split::kMedium}, {kColor, 3}, kLongCue, kLongEmpty}},
    {{{"RememberColor3-VLA-v0", 25, Split::kShort}, {kColor, 3}, kShortCue, kShortEmpty}},
    {{{"RememberColor5-Long-VLA-v0", 600, Split::kMedium}, {kColor, 5}, kFixedCue, kLongEmpty}},
    {{{"RememberColor5-VLA-v0", 25, Split::kShort}, {kColor, 5}, kShortCue, kShortEmpty}},
    {{{"RememberColor9-Long-VLA-v0", 600, Split::kMedium}, {kColor, 9}, kFixedCue, kLongEmpty}},
    {{{"RememberColor9-VLA-v0", 25, Split::kShort}, {kColor, 9}, kShortCue, kShortEmpty}},
    rl_row("RememberColor3-v0", {kColor, 3}),
    rl_row("RememberColor5-v0", {kColor, 5}),
    rl_row("RememberColor9-v0", {kColor, 9}),
}};
constexpr std::array<FindSameParams, 9> kShapes = {{
    {{{"RememberShape3-Long-VLA-v0", 600, Split::kMedium}, {kShape, 3}, kLongCue, kLongEmpty}},
    {{{"RememberShape3-VLA-v0", 25, Split::kShort}, {kShape, 3}, kShortCue, kShortEmpty}},
    {{{"RememberShape5-Long-VLA-v0", 600, Split::kMedium}, {kShape, 5}, kLongCue, kLongEmpty}},
    {{{"RememberShape5-VLA-v0", 25, Split::kShort}, {kShape, 5}, kShortCue, kShortEmpty}},
    {{{"RememberShape9-Long-VLA-v0", 600, Split::kMedium}, {kShape, 9}, kLongCue, kLongEmpty}},
    {{{"RememberShape9-VLA-v0", 25, Split::kShort}, {kShape, 9}, kShortCue, kShortEmpty}},
    rl_row("RememberShape3-v0", {kShape, 3}),
    rl_row("RememberShape5-v0", {kShape, 5}),
    rl_row("RememberShape9-v0", {kShape, 9}),
}};
constexpr std::array<FindSameParams, 9> kShapesAndColors = {{
    {{{"RememberShapeAndColor3x2-Long-VLA-v0", 600, Split::kMedium},
      {kShapeAndColor, 6},
      kLongCue,
      kLongEmpty,
      kRound}},
    {{{"RememberShapeAndColor3x2-VLA-v0", 25, Split::kShort},
      {kShapeAndColor, 6},
      kShortCue,
      kShortEmpty,
      kRound}},
    {{{"RememberShapeAndColor3x3-Long-VLA-v0", 600, Split::kMedium},
      {kShapeAndColor, 9},
      kLongCue,
      kLongEmpty}},
    {{{"RememberShapeAndColor3x3-VLA-v0", 25, Split::kShort},
      {kShapeAndColor, 9},
      kShortCue,
      kShortEmpty}},
    {{{"RememberShapeAndColor5x3-Long-VLA-v0", 600, Split::kMedium},
      {kShapeAndColor, 15},
      kLongCue,
      kLongEmpty,
      kRound}},
    {{{"RememberShapeAndColor5x3-VLA-v0", 25, Split::kShort},
      {kShapeAndColor, 15},
      kShortCue,
      kShortEmpty,
      kRound}},
    rl_row("RememberShapeAndColor3x2-v0", {kShapeAndColor, 6}, kRound),
    rl_row("RememberShapeAndColor3x3-v0", {kShapeAndColor, 9}),
    rl_row("RememberShapeAndColor5x3-v0", {kShapeAndColor, 15}, kRound),
}};

class FindSame final : public ObjectRecall {
 public:
  FindSame(const RegistryEntry& entry, const FindSameParams& params)
      : ObjectRecall(entry, params,
                     {.target = "target",
                      .target_text = "key of the object to touch",
                      .positions_text = "x, y of every object in the manipulation phase"}),
        settle_steps_(params.settle_steps()),
        forgets_contacts_(params.forgets_contacts()),
        spread_(params.spreads()) {
    if (params.task.is_rl()) return;
    success_in_cue_ =
        TaskOptions(info_.options)
            .on_off("success_in_cue", "1: to rest at the object of the cue is a success, too",
                    /*original=*/true);
  }

  void bind(const Bindings& bindings) override {
    ObjectRecall::bind(bindings);
    count_success_in_cue(success_in_cue_ && success_in_cue_->is_on(bindings));
  }

  // --- sampling ---

  void reset(const Episode& episode) override {
    begin_episode(episode);
    set_positions(episode.env(), draw_layout(episode, spread_));
  }

  // --- phases ---

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const int elapsed = engine_.state->elapsed[env];
      const bool begins = clock().begins(env, elapsed);
      switch (clock().phase(env, elapsed)) {
        case Phase::kCue:
          show_cue(env, begins);
          break;
        case Phase::kEmpty:
          if (begins) hide_all(env);
          break;
        case Phase::kManipulation:
          if (elapsed < clock().manipulation_start(env) + settle_steps_) {
            show_all(env);
          } else if (forgets_contacts_) {
            forget_contacts(env);
          }
          break;
      }
    }
  }

 private:
  // Only the target, pinned at the origin.
  void show_cue(int env, bool begins) const {
    if (begins) hide_all(env);
    const int key = target(env);
    const double center[3] = {0, 0, objects().resting_height(key)};
    engine_.state->place_prop(env, key, center, objects().quat(key));
  }

  // Nothing on the table; during the empty phase the target is reported above the origin, the
  // others above where they will stand.
  void hide_all(int env) const {
    for (int key = 0; key < count(); ++key) {
      double pos[3] = {position(env, key)[0], position(env, key)[1], kHiddenHeight};
      if (key == target(env)) pos[0] = pos[1] = 0;
      engine_.state->hide_prop(env, key, pos);
    }
  }

  void show_all(int env) const {
    for (int key = 0; key < count(); ++key) {
      engine_.state->place_prop(env, key, position(env, key), objects().quat(key));
    }
  }

  void forget_contacts(int env) const {
    for (int key = 0; key < count(); ++key) engine_.state->forget_contacts(env, key);
  }

  std::optional<TaskOption> success_in_cue_;
  int settle_steps_;
  bool forgets_contacts_;
  bool spread_;
};

}  // namespace

constexpr auto kColorRows = rows_of(kColors);
constexpr auto kShapeRows = rows_of(kShapes);
constexpr auto kShapeAndColorRows = rows_of(kShapesAndColors);

const Family kRememberColor = {
    .name = "RememberColor",
    .memory_type = "Object",
    .instruction = "Observe the cube's color, wait, then touch the cube of the same color.",
    .tasks = kColorRows,
    .make = make_variant<FindSame, kColors>,
    .expectations = {.min_reward = -0.0267, .max_reward = 0.6667, .hides = true},
    .memory = memory_facts("COLORS")};

const Family kRememberShape = {
    .name = "RememberShape",
    .memory_type = "Object",
    .instruction = "Observe the object's shape, wait, then touch the object of the same shape.",
    .tasks = kShapeRows,
    .make = make_variant<FindSame, kShapes>,
    .expectations = {.min_reward = -0.0267, .max_reward = 0.6667, .hides = true},
    .memory = memory_facts("SHAPES")};

const Family kRememberShapeAndColor = {
    .name = "RememberShapeAndColor",
    .memory_type = "Object",
    .instruction =
        "Observe the object's shape and color, wait, then touch the object of the same shape "
        "and color.",
    .tasks = kShapeAndColorRows,
    .make = make_variant<FindSame, kShapesAndColors>,
    .expectations = {.min_reward = 0, .max_reward = 0.6667, .hides = true},
    .memory = memory_facts("SHAPES")};

}  // namespace engram::tasks
