#include "tasks/shell_game/lamp_cue.h"

namespace engram::tasks {
namespace {

constexpr std::array<const char*, kCups> kBallNames = {"ball_red", "ball_green", "ball_blue"};
constexpr std::array<mjcf::Rgba, kCups> kColors = {{{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}}};
constexpr double kGlow = 2;

// Slots of red, green and blue.
constexpr std::array<std::array<std::uint8_t, kCups>, ShellLampCue::kMappingCount> kMappings = {
    {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};

}  // namespace

ShellLampCue::ShellLampCue(mjcf::Scene& scene) : first_ball_(static_cast<int>(scene.props.size())) {
  for (std::size_t color = 0; color < kCups; ++color) {
    scene.props.push_back(mjcf::visual_sphere(kBallNames[color], BALL_RADIUS, kColors[color]));
  }
  lamp_ = Lamp(scene, "lamp");
}

Draw ShellLampCue::mapping_draw() {
  return {"mapping",
          1,
          true,
          0,
          kMappingCount - 1,
          "",
          "slots of the red, green and blue ball: 012, 021, 102, 120, 201, 210"};
}

TaskOption ShellLampCue::fixed_mapping_option() {
  return {"fixed_mapping",
          0,
          true,
          0,
          1,
          "",
          "1: red left, green center, blue right in every episode, as upstream"};
}

void ShellLampCue::bind(const Bindings& bindings) {
  state_ = bindings.state;
  slot_of_color_ = bindings.memory->add<std::uint8_t>("slot_of_color", kCups);
  bindings.memory->limit("slot_of_color", 0, kCups - 1);
}

void ShellLampCue::reset(int env, int mapping,
                         const std::array<Eigen::Vector3d, kCups>& slots) const {
  static constexpr double kUpright[4] = {1, 0, 0, 0};
  const auto& chosen = kMappings[static_cast<std::size_t>(mapping)];
  for (int color = 0; color < kCups; ++color) {
    const std::uint8_t slot = chosen[static_cast<std::size_t>(color)];
    slot_of_color_.row(env)[color] = slot;
    state_->place_prop(env, first_ball_ + color, slots[slot].data(), kUpright);
  }
  const Eigen::Vector3d lamp(slots[1].x() + LAMP_BEHIND_OFFSET_X, slots[1].y(), LAMP_HEIGHT);
  lamp_.place(*state_, env, lamp.data());
  lamp_.shine(*state_, env, {});
}

void ShellLampCue::hide_balls(int env) const {
  Eigen::Vector3d parked = Eigen::Map<Eigen::Vector3d>(state_->prop_pos_of(env, first_ball_));
  parked.z() = BALL_RADIUS + HEIGHT_OFFSET;
  for (int color = 0; color < kCups; ++color) {
    state_->hide_prop(env, first_ball_ + color, parked.data());
  }
}

void ShellLampCue::show_color(int env, int color) const {
  lamp_.shine(*state_, env, {kColors[static_cast<std::size_t>(color)], kGlow});
}

}  // namespace engram::tasks
