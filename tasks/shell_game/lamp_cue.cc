#include "tasks/shell_game/lamp_cue.h"

#include <array>

#include "core/base/index.h"
#include "tasks/common/poses.h"

namespace engram::tasks {
namespace {

constexpr double LAMP_BEHIND_OFFSET_X = 0.25;  // m, from the center slot
constexpr double LAMP_HEIGHT = 0.06;           // m

constexpr std::array<const char*, kCups> kBallNames = {"ball_red", "ball_green", "ball_blue"};
constexpr std::array<mjcf::Rgba, kCups> kColors = {{{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}}};
constexpr double kGlow = 2;

// Slots of red, green and blue.
constexpr std::array<std::array<std::uint8_t, kCups>, 6> kMappings = {
    {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
constexpr const char* kMapping = "mapping";  // the variable of one of them

}  // namespace

void LampCue::declare(ConstantBinder& constants) {
  constants.fixed({{"LAMP_BEHIND_OFFSET_X", LAMP_BEHIND_OFFSET_X}, {"LAMP_HEIGHT", LAMP_HEIGHT}});
}

LampCue::LampCue(mjcf::Scene& scene, double ball_radius, RandomVariables list)
    : first_ball_(static_cast<int>(scene.props.size())),
      ball_radius_(ball_radius),
      mapping_(list.integer(kMapping, {0, static_cast<int>(kMappings.size()) - 1}, "",
                            "slots of the red, green and blue ball: 012, 021, 102, 120, 201, "
                            "210")) {
  for (std::size_t color = 0; color < kCups; ++color) {
    scene.props.push_back(mjcf::visual_sphere(kBallNames[color], ball_radius, kColors[color]));
  }
  lamp_ = Lamp(scene, "lamp");
}

void LampCue::describe(TaskInfo& info) {
  info.hidden_variable = kMapping;
  fixed_mapping_ =
      TaskOptions(info.options)
          .on_off("fixed_mapping",
                  "1: red left, green center, blue right in every episode whose mapping is not "
                  "pinned",
                  /*original=*/true);
}

void LampCue::bind(const Bindings& bindings) {
  engine_ = bindings;
  slot_of_color_ = bindings.memory->add<std::uint8_t>("slot_of_color", kCups);
  bindings.memory->limit("slot_of_color", 0, kCups - 1);
  task_cue_ = bindings.outputs->add<float>("task_cue", 1, "", "colour of the lamp");
}

void LampCue::reset(const Episode& episode, const Mugs& mugs) const {
  const int env = episode.env();
  const State& state = *engine_.state;
  const int mapping = mapping_.sample_from(episode, {0, is_fixed() ? 0 : mapping_.high()});
  const auto& slots = kMappings[at(mapping)];
  for (int color = 0; color < kCups; ++color) {
    const std::uint8_t slot = slots[at(color)];
    slot_of_color_.row(env)[color] = slot;
    const Eigen::Vector3d ball = mugs.slot_pos(env, slot, ball_radius_);
    state.place_prop(env, first_ball_ + color, ball.data(), kUprightQuat);
  }
  const Eigen::Vector3d center = mugs.base(env);
  const Eigen::Vector3d lamp(center.x() + LAMP_BEHIND_OFFSET_X, center.y(), LAMP_HEIGHT);
  lamp_.place(state, env, lamp.data());
  lamp_.shine(state, env, {});
}

bool LampCue::is_fixed() const { return fixed_mapping_.is_on(engine_); }

void LampCue::hide_balls(int env) const {
  Eigen::Vector3d parked =
      Eigen::Map<const Eigen::Vector3d>(engine_.state->prop_pos_of(env, first_ball_));
  parked.z() = ball_radius_ + HEIGHT_OFFSET;
  for (int color = 0; color < kCups; ++color) {
    engine_.state->hide_prop(env, first_ball_ + color, parked.data());
  }
}

void LampCue::show_color(int env, int color) const {
  lamp_.shine(*engine_.state, env, {kColors[at(color)], kGlow});
}

}  // namespace engram::tasks
