#include "tasks/remember/find_imposter.h"

#include <algorithm>
#include <array>
#include <span>

#include "tasks/common/overlap_guard.h"
#include "tasks/common/task_options.h"
#include "tasks/common/variant.h"
#include "tasks/remember/object_recall.h"

namespace engram::tasks {
namespace {

// --- parameters ---

using enum Vocabulary;

constexpr StepRange kCue{1, 5};
constexpr StepRange kEmpty{1, 5};
constexpr ArcParams kRound{.radius = 0.3, .compression = 0};
constexpr ArcParams kWide{.radius = 0.45, .compression = 0.025};

constexpr std::array<ObjectRecallParams, 3> kColors = {{
    {{"FindImposterColor3-VLA-v0", 25, Split::kShort}, {kColor, 3}, kCue, kEmpty},
    {{"FindImposterColor5-VLA-v0", 25, Split::kShort}, {kColor, 5}, kCue, kEmpty},
    {{"FindImposterColor9-VLA-v0", 25, Split::kShort}, {kColor, 9}, kCue, kEmpty},
}};
constexpr std::array<ObjectRecallParams, 3> kShapes = {{
    {{"FindImposterShape3-VLA-v0", 25, Split::kShort}, {kShape, 3}, kCue, kEmpty},
    {{"FindImposterShape5-VLA-v0", 25, Split::kShort}, {kShape, 5}, kCue, kEmpty},
    {{"FindImposterShape9-VLA-v0", 25, Split::kShort}, {kShape, 9}, kCue, kEmpty},
}};
constexpr std::array<ObjectRecallParams, 3> kShapesAndColors = {{
    {{"FindImposterShapeAndColor3x2-VLA-v0", 25, Split::kShort},
     {kShapeAndColor, 6},
     kCue,
     kEmpty,
     kRound},
    {{"FindImposterShapeAndColor3x3-VLA-v0", 25, Split::kShort}, {kShapeAndColor, 9}, kCue, kEmpty},
    {{"FindImposterShapeAndColor5x3-VLA-v0", 40, Split::kShort},
     {kShapeAndColor, 15},
     kCue,
     kEmpty,
     kWide},
}};

class FindImposter final : public ObjectRecall {
 public:
  FindImposter(const RegistryEntry& entry, const ObjectRecallParams& params)
      : ObjectRecall(entry, params,
                     {.target = "imposter",
                      .target_text = "key of the object that the cue leaves out",
                      .positions_text = "x, y of every object in the cue phase",
                      .imposter = true}),
        permutation_(RandomVariables(info_.random_variables)
                         .add({"permutation", count(), true, 0, count() - 1.0, "",
                               "key in whose place of the cue phase every key appears", true})),
        static_needed_(
            TaskOptions(info_.options)
                .on_off("static_needed", "1: the arm has to stand still, too", /*original=*/true)) {
    info_.answer =
        "the first object within GOAL_THRESH of which the tool comes in the manipulation phase, "
        "with static_needed rests, the nearest one if there are several; its key";
  }

  void bind(const Bindings& bindings) override {
    ObjectRecall::bind(bindings);
    need_static(static_needed_.is_on(bindings));
    cue_positions_ = bindings.memory->add<double>("cue_positions", 2 * count(), "m");
  }

  // --- sampling ---

  void reset(const Episode& episode) override {
    const int env = episode.env();
    begin_episode(episode);
    const Layout cue = draw_layout(episode, false);
    for (int key = 0; key < count(); ++key) {
      const Vec2& point = cue[at(key)];
      std::copy_n(point.data(), 2, cue_positions_.row(env) + 2 * key);
    }
    set_positions(env, shuffled(episode, cue));
  }

  // --- phases ---

  // Objects appear and vanish before the physics of the step that leads to the phase.
  void before_physics(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const int next = engine_.state->elapsed[env] + 1;
      if (!clock().begins(env, next)) continue;
      if (clock().phase(env, next) == Phase::kEmpty) hide_all(env);
      if (clock().phase(env, next) == Phase::kManipulation) release_all(env);
    }
  }

  // Objects that are shown stay in the air, even if they are touched.
  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      if (clock().phase(env, engine_.state->elapsed[env]) == Phase::kCue) show_cue(env);
    }
  }

 private:
  // Height of every origin; low shapes hover and drop.
  double shown_height() const { return objects().size(); }

  // The places of the cue phase dealt anew: key k appears where key q[k] was.
  Layout shuffled(const Episode& episode, const Layout& cue) const {
    std::array<int, Layout::kCapacity> storage{};
    const std::span q(storage.data(), cue.size());
    const auto deal = [&] {
      Layout layout;
      for (const int key : q) layout.push_back(cue[at(key)]);
      return layout;
    };
    if (const double* pinned = permutation_.pinned(episode)) {
      std::transform(pinned, pinned + q.size(), q.begin(),
                     [](double value) { return static_cast<int>(value); });
      return deal();
    }
    RandomStream random = permutation_.stream(episode);
    const auto draw = [&] {
      do random.permutation(q);
      while (std::ranges::is_sorted(q));
      return deal();
    };
    return draw_clear_layout(draw, objects().gaps());
  }

  void pos_in_cue(int env, int key, double height, double* pos) const {
    std::copy_n(cue_positions_.row(env) + 2 * key, 2, pos);
    pos[2] = height;
  }

  void show_cue(int env) const {
    double pos[3];
    for (int key = 0; key < count(); ++key) {
      const bool shown = key != target(env);
      pos_in_cue(env, key, shown ? shown_height() : kHiddenHeight, pos);
      if (shown) {
        engine_.state->place_prop(env, key, pos, objects().quat(key));
      } else {
        engine_.state->hide_prop(env, key, pos);
      }
    }
  }

  void hide_all(int env) const {
    double pos[3];
    for (int key = 0; key < count(); ++key) {
      pos_in_cue(env, key, kHiddenHeight, pos);
      engine_.state->hide_prop(env, key, pos);
    }
  }

  // Physics has them from here on.
  void release_all(int env) const {
    for (int key = 0; key < count(); ++key) {
      const double pos[3] = {position(env, key)[0], position(env, key)[1], shown_height()};
      engine_.state->place_prop(env, key, pos, objects().quat(key), PropStatus::kAwake);
    }
  }

  VariableHandle permutation_;
  TaskOption static_needed_;
  Column<double> cue_positions_;  // (count * 2) m
};

}  // namespace

constexpr auto kColorRows = rows_of(kColors);
constexpr auto kShapeRows = rows_of(kShapes);
constexpr auto kShapeAndColorRows = rows_of(kShapesAndColors);

const Family kFindImposterColor = {
    .name = "FindImposterColor",
    .memory_type = "Negative",
    .instruction =
        "Observe the cubes shown, wait, then touch the cube whose color was not present before.",
    .tasks = kColorRows,
    .make = make_variant<FindImposter, kColors>,
    .expectations = {.min_reward = -0.0267,
                     .max_reward = 0.346,
                     .moves_untouched = true,
                     .hides = true},
    .memory = memory_facts("COLORS")};

const Family kFindImposterShape = {
    .name = "FindImposterShape",
    .memory_type = "Negative",
    .instruction =
        "Observe the shapes shown, wait, then touch the object whose shape was not present "
        "before.",
    .tasks = kShapeRows,
    .make = make_variant<FindImposter, kShapes>,
    .expectations = {.min_reward = -0.0267,
                     .max_reward = 0.346,
                     .moves_untouched = true,
                     .hides = true},
    .memory = memory_facts("SHAPES")};

const Family kFindImposterShapeAndColor = {
    .name = "FindImposterShapeAndColor",
    .memory_type = "Negative",
    .instruction =
        "Observe the objects shown, wait, then touch the object whose shape and color "
        "combination was not present before.",
    .tasks = kShapeAndColorRows,
    .make = make_variant<FindImposter, kShapesAndColors>,
    .expectations = {.min_reward = 0, .max_reward = 0.346, .moves_untouched = true, .hides = true},
    .memory = memory_facts("SHAPES")};

}  // namespace engram::tasks
