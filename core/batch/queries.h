// On-demand queries of a batch: the robot, cameras, sampled values, and facts about its task.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/batch/batch.h"
#include "core/image/camera_poses.h"
#include "core/task/annotator.h"
#include "core/task/answer_controller.h"

namespace engram {

// Queries without an environment's number, but for the first three and unstable_count, are of a
// batch of one task, and throw Error for several.
class Queries {
 public:
  // The batch outlives this object.
  explicit Queries(const Batch& batch);

  // The robot in all environments, in every observation mode: (N, 9) rad and m, (N, 9), and the
  // TCP's position and quaternion (w, x, y, z) in the world (N, 7). Empty spans are left out. These
  // three throw Error for other lengths, or before the first reset.
  void robot_state(std::span<float> qpos, std::span<float> qvel, std::span<float> tcp_pose) const;
  // A camera of the scene in all environments, for images of that size.
  void camera_params(std::string_view camera, int width, int height, const CameraSpans& out);
  // Values that the episodes have drawn, (N, sampled_dim), info().sampled_values in order.
  // Privileged. Several tasks draw different values, so that there are 0 of all.
  void sampled_values(std::span<float> values) const;
  int sampled_dim() const;

  // The language instruction of an environment's episode.
  std::string instruction(int env) const;
  // Other wordings of info().instruction, and of the instruction of an environment's episode; empty
  // where there are none.
  std::vector<std::string> paraphrases() const;
  std::vector<std::string> paraphrases(int env) const;
  // The number of steps from which on nothing shows info().hidden_variable any more.
  int cue_end(int env) const;
  // The words of the episodes, after the first reset; null if the task has none. Privileged.
  const Annotator* annotator() const;

  // The controller that carries out a caller's answers; null if they have no names.
  const AnswerController* choices() const;
  // The controller of running episodes. Throws Error if answers have no names, or before the first
  // reset.
  const AnswerController& running_answer_controller() const;

  // Random variables of an episode, the engine's robot_noise first.
  const std::vector<RandomVariable>& random_variables() const { return data().pins.variables(); }
  // Fields of the observation's row, in their order: of the state, or in the objects modes of the
  // robot and the tokens.
  const std::vector<Field>& state_fields() const {
    return data().objects ? data().objects->fields() : data().state_fields;
  }
  // Values of info().options, in their order.
  std::span<const double> option_values() const { return data().option_values; }
  // Fields of the observation's row with ranges; in the objects modes only.
  std::span<const RangedField> ranged_fields() const;
  // MJCF text of the whole scene.
  std::string document() const;
  // MJCF text of an environment's episode as it is now, at rest, for MuJoCo's own step. Privileged.
  std::string drawn_document(int env) const;

  // MuJoCo's model of an environment's task, and the environment's mjData as it is now. They are
  // the batch's, and the next step or reset changes the data. Throw Error under engram's own
  // physics; mujoco_data also before the first reset.
  const mjModel& mujoco_model(int env) const;
  const mjData& mujoco_data(int env) const;

  // Environment steps that have diverged since construction.
  std::uint64_t unstable_count() const;
  // Bytes that every further environment adds.
  std::size_t bytes_per_env() const;

 private:
  BatchData& data() const;  // of a batch of one task
  BatchData& data(int part) const;
  void require_started(const char* what) const;
  // The data of the part that an environment is of, which has MuJoCo's physics, and its number
  // there.
  std::pair<BatchData&, int> locate_mujoco(int env) const;
  static std::vector<std::string> wordings(const BatchData& data, int env);

  const Batch& batch_;
  std::vector<std::unique_ptr<CameraPoses>> cameras_;  // of each part, from the first call on
};

}  // namespace engram
