#include "core/batch/batch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/error.h"
#include "core/base/ieee_scope.h"
#include "core/base/processors.h"
#include "core/contact/contact_step.h"
#include "core/observe/proprio.h"
#include "core/robot/kernel_selection.h"
#include "core/scene/model_cache.h"

namespace engram {
namespace {

constexpr double kPi = std::numbers::pi;

// Start pose of all tasks: arm in rad, fingers in m.
constexpr std::array<double, kRobotJoints> kStartQpos = {
    0, 0, 0, -2 * kPi / 3, 0, 2 * kPi / 3, kPi / 4, 0.04, 0.04};

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

// As many as move together, since among more there are more with like contacts. Ranges of a loop
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

Batch::Batch(std::unique_ptr<Task> task, const BatchOptions& options, RendererFactory renderers)
    : Batch(IeeeScope{}, std::move(task), options, std::move(renderers)) {}

Batch::Batch(const IeeeScope& /*scope*/, std::unique_ptr<Task> task, const BatchOptions& options,
             RendererFactory renderers)
    : task_(std::move(task)),
      options_(checked(options, task_->info())),
      option_values_(
          engram::option_values(task_->info().options, options_.task_options, options_.rules)),
      model_(cached_model(task_->scene())),
      controller_(std::make_unique<Controller>(*options_.control_mode, model_->arm(),
                                               model_->joint_ranges(), options_.rotation_sign)),
      pool_(options_.threads, chosen_unit(options_)),
      simulator_(std::make_unique<Simulator>(
          *model_, SimulatorOptions{options_.substeps, options_.sleep, options_.lanes},
          options_.threads, options_.num_envs)),
      renderers_(std::move(renderers)),
      tokens_(task_->object_descriptors()),
      memory_(options_.num_envs),
      pin_memory_(options_.num_envs),
      outputs_(options_.num_envs),
      final_outputs_(options_.num_envs),
      perturbations_(options_.perturbations) {
  try {
    allocate();
  } catch (const std::bad_alloc&) {
    throw Error(Error::kUnavailable, "no memory for " + std::to_string(options_.num_envs) +
                                         " environments of " + task_->info().id);
  }
  pins_.check(options_.pins);
  if (perturbations_.has(PerturbationAxis::kInstruction) &&
      task_->paraphrases(info().instruction).empty()) {
    throw Error(Error::kInvalidArgument,
                "perturbation 'instruction': " + info().id +
                    " has no other wordings of its instruction; level 0 needed");
  }
  if (options_.after_end == AfterEnd::kContinue && options_.auto_reset != AutoReset::kOff) {
    throw Error(Error::kInvalidArgument, std::string("after_end continue with auto_reset ") +
                                             name_of(options_.auto_reset) + " given, off needed");
  }
  if (info().robot_init_qpos_noise) options_.robot_init_qpos_noise = *info().robot_init_qpos_noise;
}

Batch::~Batch() = default;

// Adds all columns: the engine's memory and outputs, then the task's. Their order is part of a
// snapshot's signature.
void Batch::allocate() {
  const TaskInfo& info = task_->info();
  state_ = State(memory_, static_cast<int>(model_->props().size()),
                 max_stored_pairs(model_->collision()));
  const bool goes_on = options_.after_end == AfterEnd::kContinue;
  memory_.limit("elapsed", 0, goes_on ? kMaxElapsed : info.horizon);
  pins_ = PinTable(pin_memory_, all_variables(info, perturbations_));
  bindings_.state = &state_;
  bindings_.options = option_values_;
  bindings_.arm = &model_->arm();
  bindings_.stream_salt = stream_salt(info.id);
  bindings_.policy_salt = policy_salt(options_.policy_seed);
  for (std::size_t i = 0; i < option_values_.size(); ++i) {
    bindings_.strict |= info.options[i].name == kStrictOption && option_values_[i] != 0;
  }
  bindings_.memory = &memory_;
  bindings_.outputs = &outputs_;
  bindings_.action = memory_.add<float>("action", action_dim());
  bindings_.previous_action = memory_.add<float>("previous_action", action_dim());
  tokens_.bind(memory_);
  bindings_.freeze_steps = memory_.add<std::int32_t>("freeze_steps");
  perturbations_.bind(memory_, static_cast<int>(info.random_variables.size()));
  commands_.bind(memory_, perturbations_, action_space());
  add_state_fields();
  add_outputs();
  task_->bind(bindings_);
  rules_ = task_->batch_task();
  if (rules_ != nullptr) {
    work_.begins.resize(static_cast<std::size_t>(num_envs()));
    work_.episodes.resize(static_cast<std::size_t>(num_envs()));
  }
  if (observes_images(options_.obs_mode)) add_images();
  if (observes_objects(options_.obs_mode)) add_objects();
  final_outputs_.add_like(outputs_);
  final_mask_ = AlignedArray<std::uint8_t>(static_cast<std::size_t>(num_envs()));
}

void Batch::add_state_fields() {
  const std::vector<Field>& of_task = task_->info().state_fields;
  state_fields_ = {{"qpos", kRobotJoints, DType::kFloat32, "rad, m", "arm joints, fingers"},
                   {"qvel", kRobotJoints, DType::kFloat32, "rad/s, m/s", "arm joints, fingers"}};
  if (controller_->state_dim() > 0) {
    state_fields_.push_back({controller_->state_name(), controller_->state_dim(), DType::kFloat32,
                             "", "target that the controller tracks"});
  }
  state_fields_.push_back(
      {"tcp_pose", kTcpPoseDim, DType::kFloat32, "m", "position, quaternion (w, x, y, z)"});
  state_fields_.insert(state_fields_.end(), of_task.begin(), of_task.end());
}

void Batch::add_outputs() {
  const TaskInfo& info = task_->info();
  int dim = 0;
  for (const Field& field : state_fields_) dim += field.width;
  observation_ = outputs_.add<float>(kObservation, dim, "", "the state observation",
                                     observes_state(options_.obs_mode));
  const bool joints = options_.joint_proprio;
  proprio_ =
      outputs_.add<float>("proprio", engram::proprio_dim(joints), joints ? "rad, m" : "m, rad",
                          joints ? "joint angles of the arm, gripper opening"
                                 : "TCP position, roll, pitch, yaw, gripper opening");
  reward_ = outputs_.add<float>("reward");
  terminated_ = outputs_.add<std::uint8_t>("terminated");
  truncated_ = outputs_.add<std::uint8_t>("truncated");
  unstable_ = outputs_.add<std::uint8_t>("unstable", 1, "", "physics diverged in this step");
  elapsed_steps_ = outputs_.add<std::int32_t>("elapsed_steps", 1, "control steps");
  bindings_.success = outputs_.add<std::uint8_t>("success");
  bindings_.failed = outputs_.add<std::uint8_t>("failed");
  success_once_ =
      outputs_.add<std::uint8_t>("success_once", 1, "", "success in any step of the episode");
  episode_return_ = outputs_.add<double>("episode_return", 1, "", "sum of rewards");
  if (info.oracle_dim > 0 && info.oracle_is_real) {
    bindings_.oracle_values =
        outputs_.add_privileged<float>("oracle_info", info.oracle_dim, "", "the hidden quantity");
  } else if (info.oracle_dim > 0) {
    bindings_.oracle_info = outputs_.add_privileged<std::int32_t>("oracle_info", info.oracle_dim,
                                                                  "", "the hidden quantity");
  }
  if (info.task_cue_dim > 0) {
    bindings_.task_cue = outputs_.add_privileged<float>("task_cue", info.task_cue_dim);
  }
  if (!info.answer.empty()) bindings_.answers.bind(outputs_);
}

void Batch::add_images() {
  if (!renderers_) throw Error(Error::kUnavailable, "rgb observations without a renderer");
  const ImageKinds kinds = {observes_depth(options_.obs_mode),
                            observes_segmentation(options_.obs_mode)};
  ImageSourceOptions source = options_.image_options;
  source.varies = perturbations_.change_scene();
  source.has_faults = perturbations_.add_faults();
  images_ = std::make_unique<ImageBatch>(*model_, task_->document(), options_.images, kinds,
                                         renderers_, source, num_envs(), options_.threads,
                                         options_.auto_reset == AutoReset::kSameStep);
}

void Batch::add_objects() {
  objects_ = std::make_unique<ObjectView>(
      task_->info(), tokens_,
      ObjectViewOptions{.num_envs = num_envs(),
                        .time = options_.observe_time,
                        .keeps_final = options_.auto_reset == AutoReset::kSameStep});
}

void Batch::check_env(int env) const {
  if (env >= 0 && env < num_envs()) return;
  throw Error(Error::kInvalidArgument, "environment " + std::to_string(env) + " given, 0 to " +
                                           std::to_string(num_envs() - 1) + " allowed");
}

void Batch::require_started(const char* what) const {
  if (interrupted_) {
    throw Error(Error::kBadState, std::string(what) + " after " + info().id +
                                      " has failed in the middle of a step or reset; reset all "
                                      "environments first");
  }
  if (started_) return;
  throw Error(Error::kBadState, std::string(what) + " before the first reset; reset first");
}

// --- reset ---

Batch::CheckedReset Batch::checked_reset(const ResetRequest& request) const {
  const auto count = static_cast<std::size_t>(num_envs());
  if (!request.mask.empty()) require_length("reset mask", request.mask.size(), count);
  if (!request.seeds.empty()) require_length("reset seeds", request.seeds.size(), count);
  if (request.pins != nullptr) pins_.check(*request.pins);
  CheckedReset reset{request, request.pins, {}};
  if (reset.pins == nullptr && !started_) reset.pins = &options_.pins;
  if (request.constants != nullptr) reset.ranges = pins_.narrowed_ranges(*request.constants);
  for (int env = 0; (!started_ || interrupted_) && env < num_envs(); ++env) {
    if (reset.selects(env)) continue;
    throw Error(Error::kBadState,
                std::string(interrupted_ ? "reset after a failure of the task" : "first reset") +
                    " with environment " + std::to_string(env) +
                    " masked out; this one must reset all");
  }
  return reset;
}

void Batch::reset(const ResetRequest& request) {
  const IeeeScope scope;
  const CheckedReset reset = checked_reset(request);
  if (rules_ != nullptr) {
    reset_batch_task(reset);
    return;
  }
  pool_.run(num_envs(), options_.chunk, [&](int worker, int begin, int end) {
    reset_range(worker, {begin, end}, reset);
  });
  started_ = true;
}

void Batch::reset_range(int worker, Range envs, const CheckedReset& reset) {
  const ResetRequest& request = reset.request;
  if (clock_ != nullptr) clock(worker)->start();
  for (int env = envs.begin; env < envs.end; ++env) {
    if (!reset.selects(env)) continue;
    const auto [seed, episode] = next_episode(env, request);
    if (reset.pins != nullptr) pins_.set(env, *reset.pins);
    if (request.constants != nullptr) pins_.narrow(env, reset.ranges);
    reset_env(worker, env, seed, episode);
    mark(clock(worker), StepPart::kReset);
    render_observation(worker, env);
    final_mask_[static_cast<std::size_t>(env)] = 0;
  }
  copy_outputs(envs);
}

std::pair<std::uint64_t, std::uint64_t> Batch::next_episode(int env,
                                                            const ResetRequest& request) const {
  if (!request.seeds.empty()) return {request.seeds[static_cast<std::size_t>(env)], 0};
  if (started_) return {state_.seed[env], state_.episode[env] + 1};
  return {options_.seed + static_cast<std::uint64_t>(env), 0};
}

void Batch::reset_env(int worker, int env, std::uint64_t seed, std::uint64_t episode) {
  begin_episode(worker, env, seed, episode);
  const Range self{env, env + 1};
  task_->advance(self);
  evaluate(self);
  observe(self);
}

void Batch::begin_episode(int worker, int env, std::uint64_t seed, std::uint64_t episode_number) {
  memory_.clear_row(env);
  outputs_.clear_row(env);
  state_.seed[env] = seed;
  state_.episode[env] = episode_number;

  const Episode episode(pins_, env, bindings_.stream_key(env), episode_number);
  perturbations_.draw(episode);
  double* qpos = state_.qpos.row(env);
  std::copy(kStartQpos.begin(), kStartQpos.end(), qpos);
  const double* pinned_noise = pins_.values(env, 0);
  RandomStream noise = episode.engine_stream(kPurposeRobotNoise);
  for (int i = 0; i < kArmJoints; ++i) {
    qpos[i] +=
        pinned_noise != nullptr ? pinned_noise[i] : options_.robot_init_qpos_noise * noise.normal();
    qpos[i] += perturbations_.start_pose(env, i);
  }
  simulator_->update_tcp(state_, env, 1, worker);
  controller_->reset(state_, env);

  task_->reset(episode);
}

}  // namespace engram
