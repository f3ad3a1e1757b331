// Implementation of engram.h. Include that one.
#ifndef ENGRAM_ENGRAM_IMPL_H
#define ENGRAM_ENGRAM_IMPL_H

#include "engram/engram.h"

namespace engram {
inline namespace v0 {
namespace detail {

inline void check(engram_status status) {
  if (status != ENGRAM_OK) {
    throw Error(static_cast<Error::Kind>(status), engram_last_error());
  }
}

// A text of an environment that the function copies.
inline std::string copied(engram_env* env, int index, decltype(&engram_instruction) function) {
  std::size_t length = 0;
  check(function(env, index, nullptr, 0, &length));
  std::string text(length, ' ');
  check(function(env, index, text.data(), length + 1, nullptr));
  return text;
}

// For calls that return NULL where they fail.
inline const char* checked(const char* text) {
  if (text == nullptr) throw Error(Error::Kind::kUnavailable, engram_last_error());
  return text;
}

[[noreturn]] inline void refuse(const std::string& message) {
  throw Error(Error::Kind::kInvalidArgument, message);
}

// Converts a text for the C API, where it would end at a character 0, and mean something else.
inline const char* c_text(const std::string& text) {
  const std::size_t end = text.find('\0');
  if (end == std::string::npos) return text.c_str();
  refuse("'" + text.substr(0, end) + "' and a character 0 given, texts without one allowed");
}

// begin generated: names (tools/surface, from api/surface.toml)
inline constexpr std::array kControlModeNames = {
    "pd_joint_delta_pos",
    "pd_joint_pos",
    "pd_ee_delta_pos",
    "pd_ee_delta_pose",
    "pd_ee_pose",
    "pd_joint_target_delta_pos",
    "pd_ee_target_delta_pos",
    "pd_ee_target_delta_pose",
    "pd_joint_vel",
    "pd_joint_pos_vel",
    "pd_joint_delta_pos_vel",
};
// end generated

// Conversions of options for the C API.
inline std::int32_t plain(int value) { return value; }
inline std::uint64_t plain(std::uint64_t value) { return value; }
inline double plain(double value) { return value; }
inline std::int32_t plain(bool value) { return value ? 1 : 0; }
inline std::int32_t plain(std::optional<bool> value) { return value ? plain(*value) : -1; }
inline const char* plain(const std::string& value) { return c_text(value); }
inline std::int32_t plain(ObsMode value) { return static_cast<std::int32_t>(value); }
inline std::int32_t plain(RewardMode value) { return static_cast<std::int32_t>(value); }
inline std::int32_t plain(AutoReset value) { return static_cast<std::int32_t>(value); }
inline std::int32_t plain(AfterEnd value) { return static_cast<std::int32_t>(value); }
inline std::int32_t plain(Rules value) { return static_cast<std::int32_t>(value); }
inline std::int32_t plain(Physics value) { return static_cast<std::int32_t>(value); }
inline const char* plain(ControlMode value) {
  const auto index = static_cast<std::size_t>(value);
  return index < kControlModeNames.size() ? kControlModeNames[index] : "unknown";
}
inline const char* plain(std::optional<ControlMode> value) {
  return value ? plain(*value) : nullptr;
}

inline std::vector<engram_pin> to_c(const std::vector<Pin>& pins) {
  std::vector<engram_pin> all;
  all.reserve(pins.size());
  for (const Pin& pin : pins)
    all.push_back({c_text(pin.name), pin.values.data(), pin.values.size()});
  return all;
}

inline std::vector<engram_task_option> to_c(const std::vector<TaskOption>& options) {
  std::vector<engram_task_option> all;
  all.reserve(options.size());
  for (const TaskOption& option : options) all.push_back({c_text(option.name), option.value});
  return all;
}

inline std::vector<engram_perturbation> to_c(const std::vector<Perturbation>& perturbations) {
  std::vector<engram_perturbation> all;
  all.reserve(perturbations.size());
  for (const Perturbation& one : perturbations) all.push_back({c_text(one.axis), one.level});
  return all;
}

// Calls f with the options as the C API takes them.
template <class F>
engram_env* with_options(const EnvOptions& options, F&& f) {
  const std::vector<engram_pin> pins = to_c(options.pins);
  const std::vector<engram_task_option> task_options = to_c(options.task_options);
  const std::vector<engram_perturbation> perturbations = to_c(options.perturbations);
  std::vector<const char*> cameras;
  for (const std::string& camera : options.images.cameras) cameras.push_back(c_text(camera));
  const char* const no_camera = nullptr;

  engram_options c;
  engram_options_init(&c);
  // begin generated: copies
  c.num_envs = plain(options.num_envs);
  c.seed = plain(options.seed);
  c.threads = plain(options.threads);
  c.chunk = plain(options.chunk);
  c.obs_mode = plain(options.obs_mode);
  c.observe_time = plain(options.observe_time);
  c.joint_proprio = plain(options.joint_proprio);
  c.reward_mode = plain(options.reward_mode);
  c.control_mode = plain(options.control_mode);
  c.auto_reset = plain(options.auto_reset);
  c.rotation_sign = plain(options.rotation_sign);
  c.freeze_cue = plain(options.freeze_cue);
  c.terminate_on_success = plain(options.terminate_on_success);
  c.robot_init_qpos_noise = plain(options.robot_init_qpos_noise);
  c.sleep = plain(options.sleep);
  c.lanes = plain(options.lanes);
  c.substeps = plain(options.substeps);
  c.rules = plain(options.rules);
  c.image_width = plain(options.images.width);
  c.image_height = plain(options.images.height);
  c.renderer = plain(options.images.renderer);
  c.shadows = plain(options.images.shadows);
  c.antialias = plain(options.images.antialias);
  c.render_shadows = plain(options.render_shadows);
  c.terminate_on_failure = plain(options.terminate_on_failure);
  c.after_end = plain(options.after_end);
  c.max_episode_steps = plain(options.max_episode_steps);
  c.physics = plain(options.physics);
  // end generated
  c.pins = pins.data();
  c.num_pins = pins.size();
  c.constants = options.constants.empty() ? nullptr : c_text(options.constants);
  c.task_options = task_options.data();
  c.num_task_options = task_options.size();
  c.perturbations = perturbations.data();
  c.num_perturbations = perturbations.size();
  c.cameras = cameras.empty() ? &no_camera : cameras.data();  // NULL would mean the default ones
  c.num_cameras = cameras.size();

  engram_env* made = nullptr;
  check(f(&c, &made));
  return made;
}

inline engram_env* make_handle(const std::string& id, const EnvOptions& options) {
  return with_options(options, [&id](const engram_options* c, engram_env** made) {
    return engram_make(c_text(id), c, made);
  });
}

inline engram_env* make_handle(const std::vector<TaskShare>& tasks, const EnvOptions& options) {
  std::vector<std::vector<engram_pin>> pins;
  std::vector<std::vector<engram_task_option>> task_options;
  std::vector<engram_task_share> shares;
  for (const TaskShare& task : tasks) {
    pins.push_back(to_c(task.pins));
    task_options.push_back(to_c(task.task_options));
    const char* const constants = task.constants.empty() ? nullptr : c_text(task.constants);
    shares.push_back({c_text(task.id), task.num_envs, constants, pins.back().data(),
                      pins.back().size(), task_options.back().data(), task_options.back().size()});
  }
  return with_options(options, [&shares](const engram_options* c, engram_env** made) {
    return engram_make_group(shares.data(), shares.size(), c, made);
  });
}

// Calls f with the arguments of a reset as the C API takes them.
template <class F>
void with_reset_request(const ResetRequest& request, int num_envs, F&& f) {
  const auto check_length = [num_envs](const char* what, std::size_t given) {
    if (given == 0 || given == static_cast<std::size_t>(num_envs)) return;
    refuse(std::string(what) + ": " + std::to_string(given) + " values given, " +
           std::to_string(num_envs) + " needed");
  };
  check_length("reset mask", request.mask.size());
  check_length("reset seeds", request.seeds.size());
  engram_reset_request c{};
  if (!request.mask.empty()) c.mask = request.mask.data();
  if (!request.seeds.empty()) c.seeds = request.seeds.data();
  std::vector<engram_pin> pins;
  if (request.pins) {
    pins = to_c(*request.pins);
    c.pins = pins.data();
    c.num_pins = pins.size();
    c.has_pins = 1;
  }
  if (request.constants) c.constants = c_text(*request.constants);
  check(f(&c));
}

inline std::string joined_ids(const std::vector<TaskShare>& tasks) {
  std::string ids;
  for (const TaskShare& task : tasks) ids += (ids.empty() ? "" : "+") + task.id;
  return ids;
}

inline engram_output_target to_c(const OutputTarget& target) {
  return {c_text(target.name), target.bytes.data(), target.bytes.size()};
}

inline Output to_output(const engram_array& array) {
  return {array.name,
          array.unit,
          array.description,
          static_cast<DType>(array.dtype),
          {array.shape, array.shape + array.ndim},
          array.data};
}

template <class T>
constexpr bool holds(DType dtype) {
  if constexpr (std::is_same_v<T, std::uint8_t>) {
    return dtype == DType::kBool || dtype == DType::kUInt8;
  } else if constexpr (std::is_same_v<T, std::int16_t>) {
    return dtype == DType::kInt16;
  } else if constexpr (std::is_same_v<T, std::int32_t>) {
    return dtype == DType::kInt32;
  } else if constexpr (std::is_same_v<T, std::uint64_t>) {
    return dtype == DType::kUInt64;
  } else if constexpr (std::is_same_v<T, float>) {
    return dtype == DType::kFloat32;
  } else {
    static_assert(std::is_same_v<T, double>, "outputs have no elements of this type");
    return dtype == DType::kFloat64;
  }
}

}  // namespace detail

inline std::size_t Output::width() const {
  std::size_t count = 1;
  for (std::size_t i = 1; i < shape.size(); ++i) count *= static_cast<std::size_t>(shape[i]);
  return count;
}

template <class T>
std::span<const T> Output::values() const {
  if (!detail::holds<T>(dtype)) {
    detail::refuse("output '" + std::string(name) +
                   "': its elements are not of the type asked for");
  }
  return {static_cast<const T*>(data), static_cast<std::size_t>(shape[0]) * width()};
}

template <class T>
std::span<const T> Output::row(int env) const {
  const std::span<const T> all = values<T>();
  if (env < 0 || env >= shape[0]) {
    detail::refuse("environment " + std::to_string(env) + " given, 0 to " +
                   std::to_string(shape[0] - 1) + " allowed");
  }
  return all.subspan(static_cast<std::size_t>(env) * width(), width());
}

inline VectorEnv::VectorEnv(const std::string& id, const EnvOptions& options)
    : VectorEnv(detail::make_handle(id, options), id) {}

inline VectorEnv::VectorEnv(const std::vector<TaskShare>& tasks, const EnvOptions& options)
    : VectorEnv(detail::make_handle(tasks, options), detail::joined_ids(tasks)) {}

// Takes over the handle.
inline VectorEnv::VectorEnv(engram_env* handle_to_own, std::string id)
    : handle_(handle_to_own),
      id_(std::move(id)),
      num_envs_(engram_num_envs(handle())),
      action_dim_(engram_action_dim(handle())),
      state_dim_(engram_state_dim(handle())),
      horizon_(engram_horizon(handle())),
      action_low_(engram_action_low(handle()), static_cast<std::size_t>(action_dim_)),
      action_high_(engram_action_high(handle()), static_cast<std::size_t>(action_dim_)),
      observation_(all_of<float>("observation")),
      proprio_(all_of<float>("proprio")),
      reward_(all_of<float>("reward")),
      terminated_(all_of<std::uint8_t>("terminated")),
      truncated_(all_of<std::uint8_t>("truncated")),
      success_(all_of<std::uint8_t>("success")),
      success_once_(all_of<std::uint8_t>("success_once")),
      episode_return_(all_of<double>("episode_return")),
      elapsed_steps_(all_of<std::int32_t>("elapsed_steps")),
      unstable_(all_of<std::uint8_t>("unstable")),
      final_mask_(all_of<std::uint8_t>("final_mask")) {
  find_images();
}

inline void VectorEnv::find_images() {
  for (const Output& output : outputs()) {
    if (output.name == "rgb") rgb_ = output.values<std::uint8_t>();
    if (output.name == "depth") depth_ = output.values<std::int16_t>();
    if (output.name == "segmentation") segmentation_ = output.values<std::int16_t>();
  }
}

inline void VectorEnv::write_outputs(const std::vector<std::vector<OutputTarget>>& turns) {
  const std::size_t count = turns.empty() ? 0 : turns[0].size();
  std::vector<engram_output_target> all;
  for (const std::vector<OutputTarget>& targets : turns) {
    if (targets.size() != count) {
      detail::refuse("turns of " + std::to_string(count) + " and " +
                     std::to_string(targets.size()) + " arrays given, as many in each needed");
    }
    for (const OutputTarget& target : targets) all.push_back(detail::to_c(target));
  }
  detail::check(engram_write_outputs(handle(), all.data(), turns.size(), count));
  takes_turns_ = turns.size() > 1;
  find_images();
}

template <class T>
std::span<const T> VectorEnv::all_of(const char* name) const {
  return output(name).template values<T>();
}

inline std::string_view VectorEnv::describe() const {
  return detail::checked(engram_describe_json(handle()));
}

inline void VectorEnv::reset(const ResetRequest& request) {
  detail::with_reset_request(request, num_envs_, [this](const engram_reset_request* c) {
    return engram_reset(handle(), c);
  });
}

inline void VectorEnv::step(std::span<const float> actions) {
  detail::check(engram_step(handle(), actions.data(), actions.size()));
  if (takes_turns_) find_images();
}

inline void VectorEnv::step_no_action() {
  detail::check(engram_step_no_action(handle()));
  if (takes_turns_) find_images();
}

inline void VectorEnv::step_async(std::span<const float> actions) {
  detail::check(engram_step_async(handle(), actions.data(), actions.size()));
}

inline void VectorEnv::step_wait() {
  detail::check(engram_step_wait(handle()));
  if (takes_turns_) find_images();
}

inline void VectorEnv::act(Policy policy, std::span<float> actions) {
  detail::check(
      engram_act(handle(), static_cast<std::int32_t>(policy), actions.data(), actions.size()));
}

inline std::vector<float> VectorEnv::make_actions() const {
  return std::vector<float>(static_cast<std::size_t>(num_envs_) *
                            static_cast<std::size_t>(action_dim_));
}

inline Output VectorEnv::output(const std::string& name) const {
  engram_array array;
  detail::check(engram_output(handle(), detail::c_text(name), &array));
  return detail::to_output(array);
}

inline Output VectorEnv::final_output(const std::string& name) const {
  engram_array array;
  detail::check(engram_final_output(handle(), detail::c_text(name), &array));
  return detail::to_output(array);
}

inline std::vector<Output> VectorEnv::outputs() const {
  std::vector<Output> all;
  for (std::size_t i = 0; i < engram_num_outputs(handle()); ++i) {
    engram_array array;
    detail::check(engram_output_at(handle(), i, &array));
    all.push_back(detail::to_output(array));
  }
  return all;
}

inline std::string VectorEnv::instruction(int env) const {
  return detail::copied(handle(), env, engram_instruction);
}

inline void VectorEnv::ask(int env) { detail::check(engram_ask(handle(), env)); }

inline void VectorEnv::answer(int env, std::span<const std::int32_t> choices) {
  detail::check(engram_answer(handle(), env, choices.data(), choices.size()));
}

inline Image VectorEnv::render(int env, const std::string& camera, int width, int height) const {
  Image image{width, height, std::vector<std::uint8_t>(1)};
  // A size that is not allowed is the library's to refuse.
  if (width > 0 && height > 0 && width <= 4096 && height <= 4096) {
    image.rgb.resize(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  }
  detail::check(engram_render(handle(), env, detail::c_text(camera), width, height,
                              image.rgb.data(), image.rgb.size()));
  return image;
}

// The address of N rows of `width` floats, or null for none.
inline float* VectorEnv::rows(const char* what, std::span<float> out, std::size_t width) const {
  const std::size_t needed = static_cast<std::size_t>(num_envs_) * width;
  if (!out.empty() && out.size() != needed) {
    detail::refuse(std::string(what) + ": " + std::to_string(out.size()) + " values given, " +
                   std::to_string(needed) + " needed");
  }
  return out.empty() ? nullptr : out.data();
}

// begin generated: queries (tools/surface, from api/surface.toml)
inline std::string VectorEnv::words(int env) const {
  return detail::copied(handle(), env, engram_words);
}

inline std::string VectorEnv::question(int env) const {
  return detail::copied(handle(), env, engram_question);
}

inline void VectorEnv::robot_state(std::span<float> qpos, std::span<float> qvel,
                                   std::span<float> tcp_pose) const {
  detail::check(engram_robot_state(handle(), rows("qpos", qpos, 9), rows("qvel", qvel, 9),
                                   rows("tcp_pose", tcp_pose, 7)));
}

inline void VectorEnv::camera_params(const std::string& camera, int width, int height,
                                     const CameraParams& out) const {
  detail::check(engram_camera_params(
      handle(), detail::c_text(camera), width, height, rows("extrinsic_cv", out.extrinsic_cv, 12),
      rows("cam2world_gl", out.cam2world_gl, 16), rows("intrinsic_cv", out.intrinsic_cv, 9)));
}
// end generated

inline void VectorEnv::drawn(std::span<float> values) const {
  detail::check(engram_drawn(handle(), values.data(), values.size()));
}

inline const mjModel_* VectorEnv::mujoco_model(int env) const {
  const mjModel_* model = nullptr;
  detail::check(engram_mujoco_model(handle(), env, &model));
  return model;
}

inline const mjData_* VectorEnv::mujoco_data(int env) const {
  const mjData_* data = nullptr;
  detail::check(engram_mujoco_data(handle(), env, &data));
  return data;
}

// Converts an index that must be an environment for the C API, where -1 is the whole batch.
inline int VectorEnv::slot(int env) const { return env == ENGRAM_WHOLE_BATCH ? num_envs_ : env; }

inline Snapshot VectorEnv::save_index(int index) const {
  std::size_t size = 0;
  detail::check(engram_save(handle(), index, nullptr, 0, &size));
  Snapshot bytes(size);
  detail::check(engram_save(handle(), index, bytes.data(), bytes.size(), &size));
  return bytes;
}

inline Snapshot VectorEnv::save() const { return save_index(ENGRAM_WHOLE_BATCH); }

inline Snapshot VectorEnv::save(int env) const { return save_index(slot(env)); }

inline void VectorEnv::restore(std::span<const std::byte> snapshot) {
  detail::check(engram_restore(handle(), ENGRAM_WHOLE_BATCH, snapshot.data(), snapshot.size()));
}

inline void VectorEnv::restore(int env, std::span<const std::byte> snapshot) {
  detail::check(engram_restore(handle(), slot(env), snapshot.data(), snapshot.size()));
}

inline void register_variant(const Variant& variant) {
  const auto text = [](const std::string& value) {
    return value.empty() ? nullptr : detail::c_text(value);
  };
  detail::check(engram_register_variant(detail::c_text(variant.id), detail::c_text(variant.base),
                                        text(variant.constants), text(variant.instruction)));
}

inline void load_variants(const std::string& path) {
  detail::check(engram_load_variants(detail::c_text(path)));
}

inline void load_tasks(const std::string& path) {
  detail::check(engram_load_tasks(detail::c_text(path)));
}

inline std::vector<std::string> task_ids() {
  std::vector<std::string> ids;
  for (std::size_t i = 0; i < engram_num_tasks(); ++i) ids.emplace_back(engram_task_id(i));
  return ids;
}

inline std::string_view list() { return detail::checked(engram_list_json()); }

inline std::string_view suites() { return detail::checked(engram_suites_json()); }

}  // namespace v0
}  // namespace engram

#endif
