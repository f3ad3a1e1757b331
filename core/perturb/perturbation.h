// Perturbations: departures of an episode from its task's usual scene, robot and words, along named
// axes, for tests of how well a policy stands up to changes. What the task asks for, and what it
// hides, stays the same.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <vector>

#include "core/base/column.h"
#include "core/base/names.h"
#include "core/image/image_changes.h"
#include "core/task/episode.h"

namespace engram {

enum class PerturbationAxis {
  kCamera,
  kFov,
  kLight,
  kTable,
  kFloor,
  kDistractors,
  kOccluder,
  kNoise,
  kBlur,
  kStartPose,
  kActionDelay,
  kActionNoise,
  kInstruction,
};
inline constexpr std::array kPerturbationAxisNames = {
    "camera", "fov",  "light",      "table",        "floor",        "distractors", "occluder",
    "noise",  "blur", "start_pose", "action_delay", "action_noise", "instruction",
};
constexpr const auto& names_of(PerturbationAxis) { return kPerturbationAxisNames; }
inline constexpr std::size_t kPerturbationAxes = kPerturbationAxisNames.size();

// What happens at level 1.
const char* description_of(PerturbationAxis axis);

// A user's choice: how far episodes depart along an axis. 0: not at all; 1: as far as it goes.
struct PerturbationLevel {
  PerturbationAxis axis = PerturbationAxis::kCamera;
  double level = 0;
};

// Throws Error (kUnknownId), naming the axes, for the name of none.
PerturbationAxis require_axis(std::string_view name);
// Throws Error, naming what is allowed, unless each axis is there once, within 0 to 1.
void check_perturbations(std::span<const PerturbationLevel> levels);

// Prefix of an axis's random variable: "perturb_camera".
inline constexpr const char* kPerturbationPrefix = "perturb_";

// The perturbations of a batch's environments. Their values are a column, shares of how far each
// axis goes.
class Perturbations {
 public:
  // None.
  Perturbations() { offset_.fill(kUnused); }
  // Axes with level 0 are left out. Throws the errors of check_perturbations.
  explicit Perturbations(std::span<const PerturbationLevel> levels);

  bool any() const { return !used_.empty(); }
  bool has(PerturbationAxis axis) const {
    return offset_[static_cast<std::size_t>(axis)] != kUnused;
  }
  // Whether what cameras see differs from the scene; whether sensors have faults; either.
  bool change_scene() const;
  bool add_faults() const { return has(PerturbationAxis::kNoise) || has(PerturbationAxis::kBlur); }
  bool change_images() const { return change_scene() || add_faults(); }

  // Random variables of the axes in use. They follow the task's.
  std::vector<RandomVariable> variables() const;
  // first_variable: the number of the first of them, as the task's are counted.
  void bind(ColumnStore& memory, int first_variable);
  // Draws the values of an episode.
  void draw(const Episode& episode) const;

  ImageChanges images(int env) const;
  // Added to an arm joint of the start pose, rad.
  double start_pose(int env, int joint) const;
  // The wording of an instruction, of `count`, the task's own among them, which is 0.
  int wording(int env, int count) const;
  // Control steps from a command to its effect.
  int action_delay(int env) const;
  // Standard deviation of a command's noise as a share of the greatest.
  double action_noise(int env) const;

  static constexpr int kMaxActionDelay = 4;

 private:
  static constexpr int kUnused = -1;
  struct Used {
    PerturbationAxis axis;
    double level;
  };

  // The values of an axis, each within -1 to 1 whatever a snapshot says.
  class Shares {
   public:
    explicit Shares(const double* values) : values_(values) {}
    double operator[](std::size_t i) const {
      const double value = values_[i];
      return value >= -1 ? std::min(value, 1.0) : -1;  // also where it is no number
    }

   private:
    const double* values_;
  };
  Shares values(int env, PerturbationAxis axis) const {
    return Shares(values_.row(env) + offset_[static_cast<std::size_t>(axis)]);
  }
  static SurfaceChange surface_change(const Shares& share, RenderPattern own);
  CameraChange camera_change(int env, std::size_t camera) const;
  LightChange light_change(int env) const;
  void add_distractors(int env, ImageChanges& changes) const;

  std::vector<Used> used_;  // in the order of the axes
  int width_ = 0;
  std::array<int, kPerturbationAxes> offset_ = {};  // of an axis's values
  int first_variable_ = 0;
  Column<double> values_;
};

}  // namespace engram
