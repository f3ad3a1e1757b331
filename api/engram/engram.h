/// @file
/// engram: batched memory-manipulation tasks on CPUs. The C++ API, a thin layer over engram_c.h.
///
///     #include <engram/engram.h>
///
///     auto env = engram::make("RememberColor9-VLA-v0", {.num_envs = 256, .seed = 7});
///     std::vector<float> actions = env.make_actions();
///     for (env.reset(); true; env.step(actions)) {
///       choose(env.observation(), actions);  // or env.act(engram::Policy::kOracle, actions);
///     }
///
/// Everything that can fail throws engram::Error, whose message says what was wrong, what was given
/// and what is allowed; the failing call has then changed nothing.
///
/// N stands for the number of environments. Arrays are row by row, without gaps, one row per
/// environment; spans stay valid, and point to the same memory, for the life of the VectorEnv (also
/// when that is moved), and their content changes with reset, step and restore.
///
/// Actions of pd_ee_delta_pose, the control mode of the VLA tasks, seven floats in [-1, 1] (values
/// beyond are clipped, the rotation by its norm):
/// - 0 to 2: translation of the tool centre point, 0.1 m per unit, axes of the world
/// - 3 to 5: rotation vector about the same axes, 0.1 rad per unit, of opposite sign
///   (rotation_sign)
/// - 6: gripper: -1 closed, +1 open (0.04 m per finger)
///
/// Proprioception, seven floats: position of the tool centre point (m); roll, pitch, yaw (rad,
/// about the fixed x, y, z axes; the start pose has a roll of +-pi); opening of the gripper (m, 0
/// to 0.08).
#ifndef ENGRAM_ENGRAM_H
#define ENGRAM_ENGRAM_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "engram/engram_c.h"
#include "engram/engram_options.h"

namespace engram {
inline namespace v0 {

/// The one exception type.
class ENGRAM_API Error : public std::runtime_error {
 public:
  enum class Kind {
    kInvalidArgument = ENGRAM_INVALID_ARGUMENT,  ///< outside what is allowed, or of the wrong shape
    kUnknownId = ENGRAM_UNKNOWN_ID,              ///< no task, option or field of that name
    kUnavailable = ENGRAM_UNAVAILABLE,  ///< the machine lacks it: threads, memory, a device
    kBadState = ENGRAM_BAD_STATE,       ///< not allowed at this point
    kIo = ENGRAM_IO,                    ///< a file could not be read or written
    kInternal = ENGRAM_INTERNAL,        ///< a defect of the library itself
    kTaskFailed = ENGRAM_TASK_FAILED,   ///< the code of a user's task has failed
  };

  Error(Kind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}

  Kind kind() const noexcept { return kind_; }

 private:
  Kind kind_;
};

/// An array of the caller's for an output, as large as the output.
struct OutputTarget {
  std::string name;
  std::span<std::byte> bytes;  ///< std::as_writable_bytes(std::span(values))
};

/// Environments to reset, and their new seeds, pins and ranges. Empty members: all environments;
/// seeds, pins and ranges as before.
struct ResetRequest {
  std::span<const std::uint8_t> mask = {};    ///< N values, non-zero: reset
  std::span<const std::uint64_t> seeds = {};  ///< N values; masked-out ones are ignored
  std::optional<std::vector<Pin>> pins = {};  ///< replaces those of the reset environments
  /// Replaces their narrower ranges: a JSON object of constants that are ranges, each within that
  /// of the batch, {"EMPTY_PHASE_STEPS": [1, 3]}; pins still win.
  std::optional<std::string> constants = {};
};

/// Type of an output's elements.
enum class DType {
  kBool = ENGRAM_BOOL,  ///< std::uint8_t, 0 or 1
  kInt32 = ENGRAM_INT32,
  kUInt64 = ENGRAM_UINT64,
  kFloat32 = ENGRAM_FLOAT32,
  kFloat64 = ENGRAM_FLOAT64,
  kUInt8 = ENGRAM_UINT8,
  kInt16 = ENGRAM_INT16,
};

/// An output of a batch; cheap to copy, valid for the life of the batch.
struct Output {
  std::string_view name;
  std::string_view unit;         ///< "m", "rad"; empty where the values have none
  std::string_view description;  ///< one phrase, or empty
  DType dtype = DType::kFloat32;
  std::vector<std::int64_t> shape;  ///< N first; (N) where there is one value per environment
  const void* data = nullptr;

  /// Elements of one environment.
  std::size_t width() const;
  /// All elements. T: std::uint8_t (for kBool and kUInt8), std::int16_t, std::int32_t,
  /// std::uint64_t, float or double. Throws Error (kInvalidArgument) if that is not the output's
  /// type.
  template <class T>
  std::span<const T> values() const;
  /// Values of one environment. Throws Error (kInvalidArgument) also if there is no such
  /// environment.
  template <class T>
  std::span<const T> row(int env) const;
};

/// An image, row 0 on top.
struct Image {
  int width = 0;  ///< pixels
  int height = 0;
  std::vector<std::uint8_t> rgb;  ///< (height, width, 3)
};

/// Destinations of a camera's matrices; empty spans are left out.
struct CameraParams {
  /// (N, 3, 4) from the world to the camera: x right, y down, z forward.
  std::span<float> extrinsic_cv = {};
  /// (N, 4, 4) from the camera to the world: x right, y up, z backward.
  std::span<float> cam2world_gl = {};
  /// (N, 3, 3) in pixels; pixel (0, 0) covers 0 to 1.
  std::span<float> intrinsic_cv = {};
};

/// One environment or a whole batch as bytes, bit-exactly.
using Snapshot = std::vector<std::byte>;

/// A batch of environments, stepped in lockstep, of one task or several. Movable; a moved-from one
/// can only be assigned to and destroyed. It may be used from any thread, but from one at a time: a
/// second call meanwhile is refused with Error (kBadState).
class VectorEnv {
 public:
  /// See make() and make_group().
  VectorEnv(const std::string& id, const EnvOptions& options);
  VectorEnv(const std::vector<TaskShare>& tasks, const EnvOptions& options);

  // --- facts ---
  /// Id of the task; of several the ids, joined by "+".
  const std::string& id() const { return id_; }
  int num_envs() const { return num_envs_; }
  int num_threads() const { return engram_num_threads(handle_.get()); }
  int action_dim() const { return action_dim_; }
  int state_dim() const { return state_dim_; }  ///< floats of a state observation
  int horizon() const { return horizon_; }      ///< control steps of an episode; the longest
  /// Bounds of each action component (action_dim); infinite where there is none.
  std::span<const float> action_low() const { return action_low_; }
  std::span<const float> action_high() const { return action_high_; }
  /// The task in full as JSON: draws, options, layout of the state, outputs, constants, rewards.
  std::string_view describe() const;
  /// Environment steps in which physics diverged, since the batch was made.
  std::uint64_t unstable_count() const { return engram_unstable_count(handle_.get()); }

  // --- running it ---
  /// Starts new episodes. Without seeds, the first reset uses the option `seed` and later ones go
  /// on to the next episode of each environment. Throws Error for wrong lengths and pins, and if
  /// the first reset leaves an environment out.
  void reset(const ResetRequest& request = {});
  /// One control step (0.05 s) of all environments. actions: (N, action_dim). Throws Error if the
  /// length is wrong, a value is not finite or nothing was reset.
  void step(std::span<const float> actions);
  /// One control step without a new command: the drives keep their targets, at first those of the
  /// start pose. Throws Error if nothing was reset.
  void step_no_action();
  /// step in two halves: this one checks and copies the actions and returns. Until step_wait
  /// has returned, nothing of this batch may be read or called.
  void step_async(std::span<const float> actions);
  /// Waits until the step that step_async began is done.
  void step_wait();
  /// Writes actions for the next step, (N, action_dim). Oracle, blind and sweep need
  /// pd_ee_delta_pose, pd_joint_pos or pd_joint_delta_pos.
  void act(Policy policy, std::span<float> actions);
  /// N * action_dim zeros.
  std::vector<float> make_actions() const;

  /// From the first reset on, outputs are written to arrays of the caller's as well, and images
  /// to those alone: rgb(), depth() and segmentation() then point there. They outlive this object.
  /// Each turn has arrays for the same outputs: the first reset writes to those of turn 0, each
  /// step to those of the next turn, after the last one to those of turn 0 again. Two can be read
  /// and written side by side (step_async); many hold a rollout. Throws Error after the first reset
  /// (kBadState) and for a name or size that is wrong.
  void write_outputs(const std::vector<std::vector<OutputTarget>>& turns);
  /// The turn, from 0 on, whose arrays the last reset or step has written to.
  int output_buffer() const { return engram_output_buffer(handle_.get()); }

  // --- outputs of the last reset or step ---
  /// (N, state_dim); state and objects modes, else empty.
  std::span<const float> observation() const { return observation_; }
  /// (N, height, width, 3 * cameras); rgb modes, else empty.
  std::span<const std::uint8_t> rgb() const { return rgb_; }
  /// (N, height, width, cameras); modes with depth, else empty. Millimetres along the camera's
  /// axis, 32767 at most; 0 where nothing is.
  std::span<const std::int16_t> depth() const { return depth_; }
  /// (N, height, width, cameras); modes with segmentation, else empty. What is seen: an index into
  /// "segmentation_names" of describe(), where 0 is the background.
  std::span<const std::int16_t> segmentation() const { return segmentation_; }
  /// (N, 7) position, angles, opening of the gripper.
  std::span<const float> proprio() const { return proprio_; }
  /// (N) of this step.
  std::span<const float> reward() const { return reward_; }
  /// (N) the episode ended by its own rule.
  std::span<const std::uint8_t> terminated() const { return terminated_; }
  /// (N) the episode ended by time, or because physics diverged.
  std::span<const std::uint8_t> truncated() const { return truncated_; }
  /// (N) in this step.
  std::span<const std::uint8_t> success() const { return success_; }
  /// (N) in any step of the episode.
  std::span<const std::uint8_t> success_once() const { return success_once_; }
  /// (N) sum of the episode's rewards.
  std::span<const double> episode_return() const { return episode_return_; }
  /// (N) control steps of the episode.
  std::span<const std::int32_t> elapsed_steps() const { return elapsed_steps_; }
  /// (N) physics diverged in this step.
  std::span<const std::uint8_t> unstable() const { return unstable_; }
  /// (N) an episode ended in this step and its outputs are in final_output (kSameStep only).
  std::span<const std::uint8_t> final_mask() const { return final_mask_; }

  /// All outputs, also the task's own info fields, by name. Throws Error (kUnknownId), naming those
  /// that exist.
  Output output(const std::string& name) const;
  /// An output at the end of the episode that ended last in each environment. Throws Error
  /// (kBadState) unless auto_reset is kSameStep.
  Output final_output(const std::string& name) const;
  /// All outputs.
  std::vector<Output> outputs() const;

  /// The language instruction of one environment's episode.
  std::string instruction(int env) const;
  // begin generated: text_queries (tools/surface, from api/surface.toml)
  /// One environment's episode in words, as JSON: plan (the subtasks), subtask (index of the
  /// present one), subtasks_done, memory (what has been shown and has to be remembered), object
  /// (that is meant, or null), and paraphrases of the instruction (these for policies too).
  /// Privileged: not for policies.
  std::string words(int env) const;
  /// The question of one environment's episode (docs/choices.md), as JSON: due (the policy cannot
  /// go on without an answer), question, choices (in an order that means nothing), least and most
  /// (of an answer), repeats (one may be named twice).
  std::string question(int env) const;
  // end generated
  /// Questions (docs/choices.md) while an episode runs. ask: from now on Policy::kBlind of act
  /// waits in one environment's episode until the question is answered; to be called after each
  /// reset.
  void ask(int env);
  /// Answers it by indices of its choices. Throws Error (kBadState) if none is due.
  void answer(int env, std::span<const std::int32_t> choices);
  /// Draws one environment as it is now. camera: one of the scene's (docs/robot.md);
  /// render_camera, for people, has light and shadow. Sides 1 to 4096 pixels.
  Image render(int env, const std::string& camera = "render_camera", int width = 512,
               int height = 512) const;

  // --- queries: no part of observations ---
  // begin generated: array_queries
  /// The robot in all environments, in every observation mode: qpos (N, 9) and qvel (N, 9), arm
  /// joints and fingers, rad and m; tcp_pose (N, 7), position in m and quaternion (w, x, y, z) in
  /// the world. Empty spans are left out. Throws Error for other lengths, and before the first
  /// reset.
  void robot_state(std::span<float> qpos, std::span<float> qvel, std::span<float> tcp_pose) const;
  /// A camera of the scene in all environments, for images of that size: extrinsic_cv (N, 3, 4),
  /// from the world to the camera (x right, y down, z forward); cam2world_gl (N, 4, 4), from the
  /// camera (x right, y up, z backward) to the world; intrinsic_cv (N, 3, 3), in pixels, where
  /// pixel (0, 0) covers 0 to 1. Empty spans are left out. Throws Error for other lengths, and
  /// before the first reset.
  void camera_params(const std::string& camera, int width, int height,
                     const CameraParams& out) const;
  // end generated
  /// Values that episodes have drawn, (N, drawn_dim): "drawn" of describe() names them, in order.
  /// They reveal what policies must not know.
  void drawn(std::span<float> values) const;
  int drawn_dim() const { return engram_drawn_dim(handle_.get()); }

  // --- MuJoCo's own structures: of batches with Physics::kMujoco ---
  /// The mjModel of one environment's task, for code that is compiled with the headers of the
  /// version that mujoco_version() names. This object owns it. Throws Error (kInvalidArgument) if
  /// the physics is engram's own.
  const mjModel_* mujoco_model(int env = 0) const;
  /// The mjData of one environment as it is now, with all that mj_forward computes. The address
  /// stays for the life of this object; resets and steps change the content, which the next call
  /// brings up to date. Throws Error as above, and before the first reset.
  const mjData_* mujoco_data(int env) const;

  // --- snapshots ---
  /// The whole batch.
  Snapshot save() const;
  /// One environment.
  Snapshot save(int env) const;
  /// The whole batch, into one of the same size, task, control mode and task options. How it goes
  /// on and what is observed is up to the other options of that batch. Throws Error
  /// (kInvalidArgument) for bytes that are damaged or of something else.
  void restore(std::span<const std::byte> snapshot);
  /// One environment, into any slot of any such batch that has been reset.
  void restore(int env, std::span<const std::byte> snapshot);

  /// The batch for functions of engram_c.h; still owned by this object.
  engram_env* handle() const { return handle_.get(); }

 private:
  struct Close {
    void operator()(engram_env* env) const { engram_close(env); }
  };
  VectorEnv(engram_env* handle, std::string id);
  template <class T>
  std::span<const T> all_of(const char* name) const;
  void find_images();
  float* rows(const char* what, std::span<float> out, std::size_t width) const;
  Snapshot save_index(int index) const;
  int slot(int env) const;

  std::unique_ptr<engram_env, Close> handle_;
  std::string id_;
  bool takes_turns_ = false;  // outputs have several arrays
  int num_envs_ = 0;
  int action_dim_ = 0;
  int state_dim_ = 0;
  int horizon_ = 0;
  // Views of the batch's memory, kept here so that a debugger shows what is in them.
  std::span<const float> action_low_;
  std::span<const float> action_high_;
  std::span<const float> observation_;
  std::span<const std::uint8_t> rgb_;
  std::span<const std::int16_t> depth_;
  std::span<const std::int16_t> segmentation_;
  std::span<const float> proprio_;
  std::span<const float> reward_;
  std::span<const std::uint8_t> terminated_;
  std::span<const std::uint8_t> truncated_;
  std::span<const std::uint8_t> success_;
  std::span<const std::uint8_t> success_once_;
  std::span<const double> episode_return_;
  std::span<const std::int32_t> elapsed_steps_;
  std::span<const std::uint8_t> unstable_;
  std::span<const std::uint8_t> final_mask_;
};

/// A batch of environments of the task with that id. Throws Error: kUnknownId (with the nearest
/// id), kInvalidArgument for a bad option, kUnavailable if the machine lacks memory, threads or the
/// renderer.
inline VectorEnv make(const std::string& id, const EnvOptions& options = {}) {
  return VectorEnv(id, options);
}

/// A batch of environments of several tasks, one task behind the other. Environment i of a task has
/// options.seed + i and is, bit for bit, what it is alone; options.num_envs does not count. Outputs
/// have one array each over all environments, as wide as the widest task's, zero where a task lacks
/// them. Two more outputs: "task_index" (N), and in the objects modes "object_mask" (N, objects), 1
/// where the task has that object. "tasks" of describe() lists the tasks. Throws the errors of
/// make().
inline VectorEnv make_group(const std::vector<TaskShare>& tasks, const EnvOptions& options = {}) {
  return VectorEnv(tasks, options);
}

/// A new id for a task with other constants.
struct Variant {
  std::string id;             ///< "RememberColor7-Slow-v0"
  std::string base;           ///< "RememberColor9-VLA-v0"
  std::string constants;      ///< a JSON object: {"COLORS": 7}
  std::string instruction{};  ///< empty: that of the base
};
/// Registers it for the life of the process. Throws Error: kUnknownId if there is no such base or
/// constant, kInvalidArgument if the id is taken or the task cannot be made so.
void register_variant(const Variant& variant);
/// Registers all variants of a file, or none (docs/variants.md). Throws Error as above, and kIo.
void load_variants(const std::string& path);
/// Loads a library of tasks, for the life of the process (docs/cpp_tasks.md). Throws Error: kIo
/// if it cannot be read; kInvalidArgument if it is no such library, was made for another version or
/// with another ABI, or one of its ids is taken.
void load_tasks(const std::string& path);

/// Ids of all tasks: the benchmark's, in its order, then variants.
std::vector<std::string> task_ids();
/// JSON of all tasks: id, family, split, memory type, horizon, instruction and sizes.
std::string_view list();
/// Named lists of tasks that results are published on, as JSON: {name: {ids, episodes, seed}}.
std::string_view suites();
/// Version of the library, "0.6.0".
inline std::string_view version() { return engram_version(); }
/// Version of MuJoCo, "2.2.2".
inline std::string_view mujoco_version() { return engram_mujoco_version(); }

}  // namespace v0
}  // namespace engram

#include "engram/engram_impl.h"

#endif
