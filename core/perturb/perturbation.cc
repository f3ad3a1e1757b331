#include "core/perturb/perturbation.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "core/base/error.h"
#include "core/base/index.h"
#include "core/base/join.h"
#include "core/robot/robot_model.h"

namespace engram {
namespace {

using enum PerturbationAxis;

constexpr double kDegree = std::numbers::pi / 180;

// How far the axes go.
constexpr std::array kCameraOffset = {0.08, 0.01};              // m, base and wrist camera
constexpr std::array kCameraTurn = {8 * kDegree, 4 * kDegree};  // about each axis
constexpr double kFovChange = 12 * kDegree;
constexpr double kBrightness = 0.5;
constexpr double kLightColor = 0.25;
constexpr double kLightAzimuth = 90 * kDegree;
constexpr double kLightElevation = 20 * kDegree;
constexpr double kSurfaceColor = 0.6;
constexpr double kFinestPattern = 8;     // times as fine
constexpr double kPostY = 0.10;          // m
constexpr double kStartPoseTurn = 0.12;  // rad

// An axis: a letter for each of its values, and what happens at level 1. s: uniform within -level
// to level; p: within 0 to level; m: the level itself.
struct AxisSpec {
  const char* values;
  const char* description;
};
constexpr std::array<AxisSpec, kPerturbationAxes> kSpecs = {{
    {"ssssssssssss",
     "the base camera is moved by up to 8 cm and turned by up to 8 degrees along and about each of "
     "its axes, the wrist camera by 1 cm and 4 degrees"},
    {"ss", "the fields of view of the base and the wrist camera change by up to 12 degrees"},
    {"ssssss",
     "light is up to 50 % brighter or darker, its colours by up to 25 % each, and the slanted "
     "light comes from up to 90 degrees aside and 20 degrees above or below"},
    {"psssp",
     "the table's colours change by up to 60 % each; its surface is wood, wood turned round, "
     "tiles or plain, with a pattern up to 8 times as fine"},
    {"psssp", "the same for the floor"},
    {"mssssssssssssssssssssssss",
     "six things that no task asks for stand beside the robot: marker, stone, bottle, dish, pen, "
     "egg"},
    {"ms", "a post 4 cm wide stands between the base camera and the objects"},
    {"m", "noise of a standard deviation of 30 of 255 in the colours of every pixel"},
    {"m", "images are blurred with a standard deviation of 2 of 128 pixels"},
    {"sssssss", "each arm joint begins up to 0.12 rad off"},
    {"m", "actions take effect 4 control steps late"},
    {"m",
     "every component of an action but the gripper's has noise of a standard deviation of 0.2; of "
     "0.01 rad or m in modes that are not normalised"},
    {"p", "one of the wordings of docs/datasets.md, the task's own among them"},
}};

const AxisSpec& spec_of(PerturbationAxis axis) { return kSpecs[static_cast<std::size_t>(axis)]; }

int width_of(PerturbationAxis axis) { return static_cast<int>(std::strlen(spec_of(axis).values)); }

// A share without direction.
double positive_part(double share) { return std::max(share, 0.0); }

// One of `count` by a share of 0 to 1.
int choice(double share, int count) {
  return std::clamp(static_cast<int>(share * count), 0, count - 1);
}

}  // namespace

const char* description_of(PerturbationAxis axis) { return spec_of(axis).description; }

PerturbationAxis require_axis(std::string_view name) {
  return require_named<PerturbationAxis>("axis of perturbations", name);
}

void check_perturbations(std::span<const PerturbationLevel> levels) {
  std::array<bool, kPerturbationAxes> seen = {};
  for (const PerturbationLevel& each : levels) {
    const std::string what = std::string("perturbation '") + name_of(each.axis) + "': ";
    if (!(each.level >= 0 && each.level <= 1)) {
      throw Error(Error::kInvalidArgument,
                  what + "level " + shortest(each.level) + " given, 0 to 1 allowed");
    }
    bool& twice = seen[static_cast<std::size_t>(each.axis)];
    if (twice) throw Error(Error::kInvalidArgument, what + "given twice, once allowed");
    twice = true;
  }
}

Perturbations::Perturbations(std::span<const PerturbationLevel> levels) : Perturbations() {
  check_perturbations(levels);
  for (const PerturbationLevel& each : levels) {
    if (each.level > 0) used_.push_back({each.axis, each.level});
  }
  std::ranges::sort(used_, {}, &Used::axis);
  for (const Used& each : used_) {
    offset_[static_cast<std::size_t>(each.axis)] = width_;
    width_ += width_of(each.axis);
  }
}

bool Perturbations::change_scene() const {
  return has(kCamera) || has(kFov) || has(kLight) || has(kTable) || has(kFloor) ||
         has(kDistractors) || has(kOccluder);
}

std::vector<RandomVariable> Perturbations::variables() const {
  std::vector<RandomVariable> variables;
  for (const Used& each : used_) {
    const bool is_signed = std::strchr(spec_of(each.axis).values, 's') != nullptr;
    RandomVariable variable;
    variable.name = std::string(kPerturbationPrefix) + name_of(each.axis);
    variable.width = width_of(each.axis);
    variable.low = is_signed ? -1 : 0;
    variable.high = 1;
    variable.description = std::string("shares of: ") + description_of(each.axis);
    variables.push_back(std::move(variable));
  }
  return variables;
}

void Perturbations::bind(ColumnStore& memory, int first_variable) {
  first_variable_ = first_variable;
  if (any()) values_ = memory.add<double>("perturbations", width_);
}

// Levels scale the same draws, so that episodes at different levels depart in the same direction.
void Perturbations::draw(const Episode& episode) const {
  for (std::size_t i = 0; i < used_.size(); ++i) {
    const auto& [axis, level] = used_[i];
    const char* letters = spec_of(axis).values;
    const double* pinned = episode.pinned(first_variable_ + static_cast<int>(i));
    RandomStream stream =
        episode.engine_stream(kPurposePerturbation + static_cast<std::uint32_t>(axis));
    double* out = values_.row(episode.env()) + offset_[static_cast<std::size_t>(axis)];
    for (int k = 0; k < width_of(axis); ++k) {
      const double share = stream.uniform();
      const double drawn = letters[k] == 's' ? 2 * share - 1 : letters[k] == 'p' ? share : 1;
      const double value = pinned != nullptr ? pinned[k] : level * drawn;
      out[k] = letters[k] == 's' ? value : std::max(value, 0.0);
    }
  }
}

ImageChanges Perturbations::images(int env) const {
  ImageChanges changes;
  changes.cameras = has(kCamera) || has(kFov);
  for (std::size_t i = 0; changes.cameras && i < changes.camera.size(); ++i) {
    changes.camera[i] = camera_change(env, i);
  }
  changes.lights = has(kLight);
  if (changes.lights) changes.light = light_change(env);
  changes.table = has(kTable);
  if (changes.table) {
    changes.table_surface = surface_change(values(env, kTable), RenderPattern::kWood);
  }
  changes.ground = has(kFloor);
  if (changes.ground) {
    changes.ground_surface = surface_change(values(env, kFloor), RenderPattern::kGrid);
  }
  if (has(kDistractors)) add_distractors(env, changes);
  if (has(kOccluder)) {
    changes.post_width = positive_part(values(env, kOccluder)[0]);
    changes.post_y = kPostY * values(env, kOccluder)[1];
  }
  if (has(kNoise)) changes.noise = kMaxNoiseLevels * positive_part(values(env, kNoise)[0]);
  if (has(kBlur)) changes.blur = kWidestBlur * positive_part(values(env, kBlur)[0]);
  return changes;
}

// Values of table and floor: what the surface shows, three colours, fineness.
SurfaceChange Perturbations::surface_change(const Shares& share, RenderPattern own) {
  constexpr int kLooks = 4;
  SurfaceChange change;
  for (std::size_t k = 0; k < 3; ++k) {
    change.color[k] = static_cast<float>(kSurfaceColor * share[1 + k]);
  }
  change.surface.pattern = own;
  change.surface.scale = static_cast<float>(1 + (kFinestPattern - 1) * std::max(share[4], 0.0));
  switch (choice(share[0], kLooks)) {
    case 1:
      change.surface.pattern = RenderPattern::kWood;
      change.surface.turned = true;
      break;
    case 2:  // the other one
      change.surface.pattern =
          own == RenderPattern::kWood ? RenderPattern::kGrid : RenderPattern::kWood;
      break;
    case 3:
      change.surface.pattern = RenderPattern::kPlain;
      break;
    default:
      break;
  }
  return change;
}

CameraChange Perturbations::camera_change(int env, std::size_t camera) const {
  CameraChange change;
  if (has(kCamera)) {
    const Shares share = values(env, kCamera);
    for (std::size_t k = 0; k < 3; ++k) {
      change.offset[k] = kCameraOffset[camera] * share[6 * camera + k];
      change.rotation[k] = kCameraTurn[camera] * share[6 * camera + 3 + k];
    }
  }
  if (has(kFov)) change.fovy = kFovChange * values(env, kFov)[camera];
  return change;
}

LightChange Perturbations::light_change(int env) const {
  const Shares share = values(env, kLight);
  LightChange change;
  change.brightness = kBrightness * share[0];
  for (std::size_t k = 0; k < 3; ++k) change.color[k] = kLightColor * share[1 + k];
  change.azimuth = kLightAzimuth * share[4];
  change.elevation = kLightElevation * share[5];
  return change;
}

void Perturbations::add_distractors(int env, ImageChanges& changes) const {
  const Shares share = values(env, kDistractors);
  changes.distractor_count =
      static_cast<int>(std::lround(kMaxDistractors * positive_part(share[0])));
  for (std::size_t i = 0; i < kMaxDistractors; ++i) {
    const std::size_t at = 1 + 4 * i;
    changes.distractors[i] = {{share[at], share[at + 1]},
                              std::numbers::pi * share[at + 2],
                              choice(0.5 + 0.5 * share[at + 3], kDistractorColors)};
  }
}

double Perturbations::start_pose(int env, int joint) const {
  return has(kStartPose) ? kStartPoseTurn * values(env, kStartPose)[at(joint)] : 0;
}

int Perturbations::wording(int env, int count) const {
  return has(kInstruction) ? choice(values(env, kInstruction)[0], count) : 0;
}

int Perturbations::action_delay(int env) const {
  if (!has(kActionDelay)) return 0;
  return static_cast<int>(
      std::lround(kMaxActionDelay * positive_part(values(env, kActionDelay)[0])));
}

double Perturbations::action_noise(int env) const {
  return has(kActionNoise) ? positive_part(values(env, kActionNoise)[0]) : 0;
}

}  // namespace engram
