#include "tasks/remember/find_imposter.h"

#include <algorithm>
#include <array>
#include <span>

#include "tasks/parts/overlap_guard.h"
#include "tasks/parts/variant.h"
#include "tasks/remember/object_recall.h"

namespace engram::tasks {
namespace {

// --- parameters ---

using enum Vocabulary;

constexpr StepRange kCue{1, 5};
constexpr StepRange kEmpty{1, 5};
constexpr ArcParams kRound{.radius = 0.3, .compression = 0};
constexpr ArcParams kWide{.radius = 0.45, .compression = 0.025};

constexpr std::array<ObjectRecallParams, 9> kVariants = {{
    {"FindImposterColor3-VLA-v0", kColor, 3, kCue, kEmpty},
    {"FindImposterColor5-VLA-v0", kColor, 5, kCue, kEmpty},
    {"FindImposterColor9-VLA-v0", kColor, 9, kCue, kEmpty},
    {"FindImposterShape3-VLA-v0", kShape, 3, kCue, kEmpty},
    {"FindImposterShape5-VLA-v0", kShape, 5, kCue, kEmpty},
    {"FindImposterShape9-VLA-v0", kShape, 9, kCue, kEmpty},
    {"FindImposterShapeAndColor3x2-VLA-v0", kShapeAndColor, 6, kCue, kEmpty, kRound},
    {"FindImposterShapeAndColor3x3-VLA-v0", kShapeAndColor, 9, kCue, kEmpty},
    {"FindImposterShapeAndColor5x3-VLA-v0", kShapeAndColor, 15, kCue, kEmpty, kWide},
}};

// Height of every origin when it is shown; low shapes hover and drop.
constexpr double kShownHeight = 0.02;  // m

class FindImposter final : public ObjectRecall {
 public:
  FindImposter(const RegistryEntry& entry, const ObjectRecallParams& params)
      : ObjectRecall(entry, params,
                     {.target = "imposter",
                      .target_text = "key of the object that the cue leaves out",
                      .positions_text = "x, y of every object in the cue phase"}) {
    add_draw({.name = "permutation",
              .width = count(),
              .integer = true,
              .low = 0,
              .high = count() - 1.0,
              .unit = "",
              .description = "key in whose place of the cue phase every key appears",
              .distinct = true});
  }

  void bind(const Bindings& bindings) override {
    ObjectRecall::bind(bindings);
    cue_positions_ = bindings.memory->add<double>("cue_positions", 2 * count(), "m");
  }

  // --- sampling ---

  void reset(const Episode& episode) override {
    const int env = episode.env();
    begin_episode(episode);
    const Layout cue = draw_layout(episode, false);
    for (int key = 0; key < count(); ++key) {
      const Vec2& point = cue[static_cast<std::size_t>(key)];
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

  // What is shown stays in the air, whatever happens to it.
  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      if (clock().phase(env, engine_.state->elapsed[env]) == Phase::kCue) show_cue(env);
    }
  }

 private:
  static constexpr int kPermutation = kFamilyDraws;

  // The places of the cue phase dealt anew: key k appears where key q[k] was.
  Layout shuffled(const Episode& episode, const Layout& cue) const {
    std::array<int, Layout::kCapacity> storage{};
    const std::span q(storage.data(), cue.size());
    const auto deal = [&] {
      Layout layout;
      for (const int key : q) layout.push_back(cue[static_cast<std::size_t>(key)]);
      return layout;
    };
    if (const double* pinned = episode.pinned(kPermutation)) {
      std::transform(pinned, pinned + q.size(), q.begin(),
                     [](double value) { return static_cast<int>(value); });
      return deal();
    }
    RandomStream random = episode.stream(kPermutation);
    const auto draw = [&] {
      do random.permutation(q);
      while (std::ranges::is_sorted(q));
      return deal();
    };
    return draw_clear_layout(draw, clearance());
  }

  void pos_in_cue(int env, int key, double height, double* pos) const {
    std::copy_n(cue_positions_.row(env) + 2 * key, 2, pos);
    pos[2] = height;
  }

  void show_cue(int env) const {
    double pos[3];
    for (int key = 0; key < count(); ++key) {
      const bool shown = key != target(env);
      pos_in_cue(env, key, shown ? kShownHeight : kHiddenHeight, pos);
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
      const double pos[3] = {position(env, key)[0], position(env, key)[1], kShownHeight};
      engine_.state->place_prop(env, key, pos, objects().quat(key), PropStatus::kAwake);
    }
  }

  Column<double> cue_positions_;  // (count * 2) m
};

}  // namespace

std::unique_ptr<Task> make_find_imposter(const RegistryEntry& entry) {
  return std::make_unique<FindImposter>(entry, find_variant(kVariants, entry.id));
}

}  // namespace engram::tasks
