#include "core/batch/batch_data.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/contact/contact_step.h"
#include "core/observe/proprio.h"
#include "core/robot/lane_kernel.h"
#include "core/scene/model_cache.h"
#include "core/threads/processors.h"

namespace engram {
namespace {

constexpr int kTcpPoseDim = 7;

int lanes_of(const BatchOptions& options) {
  return options.lanes > 0 ? options.lanes : lane_kernel_for(options.num_envs).lanes;
}

// Environments that workers do not share: whole blocks of lanes, since part of a block takes the
// time of all of it. With images, which take longer, half a block pays for another thread.
int chosen_unit(const BatchOptions& options) {
  const int lanes = lanes_of(options);
  const bool halves = observes_images(options.obs_mode) && options.threads > 1;
  return halves ? (lanes + 1) / 2 : lanes;
}

// Environments that move together: among more there are more with like contacts. Ranges of a loop
// that workers share get shorter towards its end, since some environments take longer than others.
int chosen_chunk(const BatchOptions& options) {
  const int lanes = lanes_of(options);
  if (options.num_envs <= options.threads * lanes) return chosen_unit(options);
  const int chunk = std::min(options.num_envs / options.threads, Simulator::kMaxTogether);
  return std::max(lanes, chunk - chunk % lanes);
}

BatchOptions checked(BatchOptions options, const TaskInfo& task) {
  check_ranges(options);
  if (!options.control_mode) options.control_mode = task.control_mode;
  if (options.threads == 0) {
    options.threads = std::min(available_processors(), kMaxThreads);
  }
  options.threads = std::min(options.threads, options.num_envs);
  if (options.chunk == 0) options.chunk = chosen_chunk(options);
  return options;
}

// The engine's variable first, then the task's, then those of perturbations.
std::vector<RandomVariable> all_variables(const TaskInfo& info,
                                          const Perturbations& perturbations) {
  std::vector<RandomVariable> variables = {{kRobotNoiseVariable, kArmJoints, false, -1, 1, "rad",
                                            "added to the seven arm joints of the start pose"}};
  variables.insert(variables.end(), info.random_variables.begin(), info.random_variables.end());
  const std::vector<RandomVariable> more = perturbations.variables();
  variables.insert(variables.end(), more.begin(), more.end());
  return variables;
}

}  // namespace

BatchData::BatchData(std::unique_ptr<Task> given_task, const BatchOptions& given,
                     RendererFactory given_renderers)
    : task(std::move(given_task)),
      options(checked(given, task->info())),
      option_values(
          engram::option_values(task->info().options, options.task_options, options.rules)),
      model(cached_model(task->scene())),
      controller(std::make_unique<Controller>(*options.control_mode, model->arm(),
                                              model->joint_ranges(), options.rotation_sign)),
      simulator(std::make_unique<Simulator>(
          *model, SimulatorOptions{options.substeps, options.sleep, options.lanes}, options.threads,
          options.num_envs)),
      renderers(std::move(given_renderers)),
      tokens(task->object_descriptors()),
      memory(options.num_envs),
      pin_memory(options.num_envs),
      outputs(options.num_envs),
      final_outputs(options.num_envs),
      perturbations(options.perturbations) {
  try {
    allocate();
  } catch (const std::bad_alloc&) {
    throw Error(Error::kUnavailable, "no memory for " + std::to_string(options.num_envs) +
                                         " environments of " + task->info().id);
  }
  pins.check(options.pins);
  if (perturbations.has(PerturbationAxis::kInstruction) &&
      task->paraphrases(info().instruction).empty()) {
    throw Error(Error::kInvalidArgument,
                "perturbation 'instruction': " + info().id +
                    " has no other wordings of its instruction; level 0 needed");
  }
  if (options.after_end == AfterEnd::kContinue && options.auto_reset != AutoReset::kOff) {
    throw Error(Error::kInvalidArgument, std::string("after_end continue with auto_reset ") +
                                             name_of(options.auto_reset) + " given, off needed");
  }
  if (info().robot_init_qpos_noise) options.robot_init_qpos_noise = *info().robot_init_qpos_noise;
}

BatchData::~BatchData() = default;

int BatchData::range_unit() const { return chosen_unit(options); }

// Adds all columns: the engine's memory and outputs, then the task's. Their order is part of a
// snapshot's signature.
void BatchData::allocate() {
  const TaskInfo& info = task->info();
  state =
      State(memory, static_cast<int>(model->props().size()), max_stored_pairs(model->collision()));
  if (options.physics == Physics::kMujoco) {
    mujoco = std::make_unique<MujocoPhysics>(task->scene(), *model, options.substeps,
                                             options.threads, num_envs(), memory);
  }
  const bool goes_on = options.after_end == AfterEnd::kContinue;
  memory.limit("elapsed", 0, goes_on ? kMaxElapsed : info.horizon);
  pins = PinTable(pin_memory, all_variables(info, perturbations));
  bindings.state = &state;
  bindings.options = option_values;
  bindings.arm = &model->arm();
  bindings.stream_salt = stream_salt(info.id);
  bindings.policy_salt = policy_salt(options.policy_seed);
  for (std::size_t i = 0; i < option_values.size(); ++i) {
    bindings.strict |= info.options[i].name == kStrictOption && option_values[i] != 0;
  }
  bindings.memory = &memory;
  bindings.outputs = &outputs;
  bindings.action = memory.add<float>("action", action_dim());
  bindings.previous_action = memory.add<float>("previous_action", action_dim());
  tokens.bind(memory);
  bindings.freeze_steps = memory.add<std::int32_t>("freeze_steps");
  perturbations.bind(memory, static_cast<int>(info.random_variables.size()));
  commands.bind(memory, perturbations, controller->action_space());
  add_state_fields();
  add_outputs();
  task->bind(bindings);
  batch_task = task->batch_task();
  if (observes_images(options.obs_mode)) add_images();
  if (observes_objects(options.obs_mode)) add_objects();
  final_outputs.add_like(outputs);
  final_mask = AlignedArray<std::uint8_t>(at(num_envs()));
  stages.resize(at(num_envs()));
  if (batch_task != nullptr) list.reserve(at(num_envs()));
}

void BatchData::add_state_fields() {
  const std::vector<Field>& of_task = task->info().state_fields;
  state_fields = {{"qpos", kRobotJoints, DType::kFloat32, "rad, m", "arm joints, fingers"},
                  {"qvel", kRobotJoints, DType::kFloat32, "rad/s, m/s", "arm joints, fingers"}};
  if (controller->state_dim() > 0) {
    state_fields.push_back({controller->state_name(), controller->state_dim(), DType::kFloat32, "",
                            "target that the controller tracks"});
  }
  state_fields.push_back(
      {"tcp_pose", kTcpPoseDim, DType::kFloat32, "m", "position, quaternion (w, x, y, z)"});
  state_fields.insert(state_fields.end(), of_task.begin(), of_task.end());
}

void BatchData::add_outputs() {
  const TaskInfo& info = task->info();
  int dim = 0;
  for (const Field& field : state_fields) dim += field.width;
  observation = outputs.add<float>(kObservation, dim, "", "the state observation",
                                   observes_state(options.obs_mode));
  const bool joints = options.joint_proprio;
  proprio = outputs.add<float>("proprio", engram::proprio_dim(joints), joints ? "rad, m" : "m, rad",
                               joints ? "joint angles of the arm, gripper opening"
                                      : "TCP position, roll, pitch, yaw, gripper opening");
  reward = outputs.add<float>("reward");
  terminated = outputs.add<std::uint8_t>("terminated");
  truncated = outputs.add<std::uint8_t>("truncated");
  unstable = outputs.add<std::uint8_t>("unstable", 1, "", "physics diverged in this step");
  elapsed_steps = outputs.add<std::int32_t>("elapsed_steps", 1, "control steps");
  bindings.success = outputs.add<std::uint8_t>("success");
  bindings.failed = outputs.add<std::uint8_t>("failed");
  success_once =
      outputs.add<std::uint8_t>("success_once", 1, "", "success in any step of the episode");
  episode_return = outputs.add<double>("episode_return", 1, "", "sum of rewards");
  if (info.oracle_dim > 0 && info.oracle_is_real) {
    bindings.oracle_values =
        outputs.add_privileged<float>("oracle_info", info.oracle_dim, "", "the hidden quantity");
  } else if (info.oracle_dim > 0) {
    bindings.oracle_info = outputs.add_privileged<std::int32_t>("oracle_info", info.oracle_dim, "",
                                                                "the hidden quantity");
  }
  if (info.task_cue_dim > 0) {
    bindings.task_cue = outputs.add_privileged<float>("task_cue", info.task_cue_dim);
  }
  if (!info.answer.empty()) bindings.answers.bind(outputs);
}

void BatchData::add_images() {
  if (!renderers) throw Error(Error::kUnavailable, "rgb observations without a renderer");
  const ImageKinds kinds = {observes_depth(options.obs_mode),
                            observes_segmentation(options.obs_mode)};
  ImageSourceOptions source = options.image_options;
  source.varies = perturbations.change_scene();
  source.has_faults = perturbations.add_faults();
  images = std::make_unique<ImageBatch>(*model, task->document(), options.images, kinds, renderers,
                                        source, num_envs(), options.threads,
                                        options.auto_reset == AutoReset::kSameStep);
}

void BatchData::add_objects() {
  objects = std::make_unique<ObjectView>(
      task->info(), tokens,
      ObjectViewOptions{.num_envs = num_envs(),
                        .time = options.observe_time,
                        .keeps_final = options.auto_reset == AutoReset::kSameStep});
}

void BatchData::check_env(int env) const {
  if (env >= 0 && env < num_envs()) return;
  throw Error(Error::kInvalidArgument, "environment " + std::to_string(env) + " given, 0 to " +
                                           std::to_string(num_envs() - 1) + " allowed");
}

// An episode has ended that nothing resets but the caller.
void BatchData::refuse_ended() const {
  if (options.after_end != AfterEnd::kRefuse || options.auto_reset != AutoReset::kOff) return;
  for (int env = 0; env < num_envs(); ++env) {
    if (state.finished[env] == 0) continue;
    throw Error(Error::kBadState,
                "the episode of environment " + std::to_string(first_env + env) +
                    " has ended; reset it, or make the batch with after_end hold or continue");
  }
}

void BatchData::require_started(const char* what) const {
  if (interrupted) {
    throw Error(Error::kBadState, std::string(what) + " after " + info().id +
                                      " has failed in the middle of a step or reset; reset all "
                                      "environments first");
  }
  if (started) return;
  throw Error(Error::kBadState, std::string(what) + " before the first reset; reset first");
}

CheckedReset BatchData::checked_reset(const ResetRequest& request) const {
  const auto count = at(num_envs());
  if (!request.mask.empty()) require_length("reset mask", request.mask.size(), count);
  if (!request.seeds.empty()) require_length("reset seeds", request.seeds.size(), count);
  if (request.pins != nullptr) pins.check(*request.pins);
  CheckedReset reset{request, request.pins, {}};
  if (reset.pins == nullptr && !started) reset.pins = &options.pins;
  if (request.constants != nullptr) reset.ranges = pins.narrowed_ranges(*request.constants);
  for (int env = 0; (!started || interrupted) && env < num_envs(); ++env) {
    if (request.selects(env)) continue;
    throw Error(Error::kBadState,
                std::string(interrupted ? "reset after a failure of the task" : "first reset") +
                    " with environment " + std::to_string(env) +
                    " masked out; this one must reset all");
  }
  return reset;
}

}  // namespace engram
