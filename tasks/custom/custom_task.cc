#include "tasks/custom/custom_task.h"

#include <algorithm>
#include <functional>

#include "core/base/error.h"
#include "tasks/common/task_options.h"

namespace engram::tasks {
namespace {

constexpr std::size_t kMaxDraws = 60;
constexpr int kActionDim = 7;  // of pd_ee_delta_pose
// In the column "moved": the pose is the same, but contact points are to be found anew.
constexpr std::uint8_t kOnlyContacts = 2;

[[noreturn]] void refuse(const std::string& id, const std::string& why) {
  throw Error(Error::kInvalidArgument, "task '" + id + "': " + why);
}

int width_of(const std::vector<Field>& fields) {
  int width = 0;
  for (const Field& field : fields) width += field.width;
  return width;
}

[[noreturn]] void refuse_taken(const std::string& id, const std::string& what,
                               const std::string& name) {
  refuse(id, what + " '" + name + "': the name is taken, another one needed");
}

// Throws Error unless all names are different, and none is among those that are taken.
template <class Items, class Name>
void check_names(const std::string& id, const std::string& what, const Items& items, Name name,
                 std::vector<std::string> taken) {
  for (const auto& item : items) {
    const std::string& own = std::invoke(name, item);
    if (std::ranges::find(taken, own) != taken.end()) {
      refuse_taken(id, what, own);
    }
    taken.push_back(own);
  }
}

const char* name_of(Script script) {
  switch (script) {
    case Script::kOracle:
      return "oracle";
    case Script::kBlind:
      return "blind";
    case Script::kSweep:
      return "sweep";
  }
  return "";
}

}  // namespace

CustomTask::CustomTask(const RegistryEntry& entry, std::unique_ptr<CustomInstance> instance)
    : FamilyBase(entry),
      instance_(std::move(instance)),
      about_(instance_->description()),
      draws_(about_.draws),
      annotator_(about_, draws_) {
  describe(about_);
}

void CustomTask::describe(const CustomDescription& about) {
  if (about.draws.size() > kMaxDraws) {
    refuse(info_.id, std::to_string(about.draws.size()) + " draws given, at most " +
                         std::to_string(kMaxDraws) + " allowed");
  }
  info_.candidates = about.candidates;
  info_.guess_rate = about.guess_rate;
  info_.answer = about.answer;
  info_.answer_rate = about.answer_rate;
  info_.termination = about.termination;
  info_.frozen_cue = about.frozen_cue;
  info_.success_reward = about.success_reward;
  info_.oracle_dim = about.oracle_dim;
  info_.hidden_variable = about.hidden;
  info_.phases = about.phases;
  info_.random_variables = draws_.variables();
  info_.sampled_values = draws_.fields();
  info_.state_fields = about.state_fields;
  scene_.props = about.props;
  scene_.table_ends = about.table_ends;
  check_names(info_.id, "draw", info_.random_variables, &RandomVariable::name,
              {kRobotNoiseVariable});
  check_names(info_.id, "state field", info_.state_fields, &Field::name,
              {"qpos", "qvel", "target_qpos", "target_pose", "tcp_pose"});
  check_names(info_.id, "prop", scene_.props, &mjcf::Prop::name, {});
  const bool hidden_known = std::ranges::any_of(
      about.draws, [&](const CustomDraw& draw) { return draw.name == about.hidden; });
  if (!about.hidden.empty() && !hidden_known) {
    refuse(info_.id, "hidden variable '" + about.hidden + "' given, the name of a draw needed");
  }
}

// --- columns ---

void CustomTask::bind(const Bindings& bindings) {
  FamilyBase::bind(bindings);
  arrays_ = std::make_unique<ArrayExchange>(bindings.memory->num_envs());
  draws_.bind(*bindings.memory);
  cue_end_ = bindings.memory->add<std::int32_t>("cue_end", 1, "control steps");
  if (has_words()) annotator_.bind(*bindings.memory, bindings.success);
  add_engine_columns();
  add_own_columns();
  arrays_->bind(*instance_);
}

void CustomTask::add_engine_columns() {
  const ColumnStore& memory = *engine_.memory;
  for (const char* name : {"elapsed", "seed", "episode", "qpos", "qvel", "tcp_pos", "tcp_quat",
                           "action", "previous_action", "finger_force"}) {
    arrays_->add(memory, name, false);
  }
  for (const char* name : {"prop_pos", "prop_quat", "prop_qvel", "prop_rgba", "prop_emission",
                           "covered", "freeze_steps", "cue_end"}) {
    arrays_->add(memory, name, true);
  }
  if (has_words()) {
    for (const char* name : {"subtask", "shown", "meant"}) arrays_->add(memory, name, true);
  }
  arrays_->add_bytes(memory, "prop_status", true);
  const ColumnStore& outputs = *engine_.outputs;
  for (const char* name : {"success", "failed"}) arrays_->add(outputs, name, true);
  if (info_.oracle_dim > 0) arrays_->add(outputs, "oracle_info", true);
  if (info_.answer.empty()) return;
  for (const char* name : {"answered", "first_answer", "first_answer_correct"}) {
    arrays_->add(outputs, name, true);
  }
}

void CustomTask::add_own_columns() {
  const auto add_work = [this]<class T>(Column<T>& column, const char* name, int width,
                                        bool is_written, DType dtype = dtype_of<T>()) {
    std::byte* rows = arrays_->add_own({name, width, dtype, "", ""}, is_written);
    column = Column<T>(reinterpret_cast<T*>(rows), width);
  };
  const int props = std::max(1, engine_.state->num_props);
  add_work(moved_, "moved", props, true, DType::kUInt8);
  add_work(reward_, "reward", 1, true);
  add_work(actions_, "actions", kActionDim, true);
  add_work(policy_key_, "policy_key", 1, false);
  if (has_choices()) add_work(choice_, "choice", about_.choices.count, false);
  const int state_dim = width_of(info_.state_fields);
  if (state_dim > 0) add_work(state_, "state", state_dim, true);
  for (const CustomDraw& draw : about_.draws) {
    arrays_->add(*engine_.memory, draw_column(draw.name), false);
  }
  const auto add = [this](ColumnStore& store, CustomColumn column, const std::string& prefix,
                          bool in_store) {
    if (in_store && store.find(column.field.name).field != nullptr) {
      refuse(info_.id, "info '" + column.field.name + "': the name is taken, another one needed");
    }
    const std::string shown = prefix + column.field.name;
    if (!in_store) column.field.name = shown;
    const std::string name = column.field.name;
    store.add(column.field);
    if (column.limits) store.limit(name, column.limits->first, column.limits->second);
    arrays_->add(store, name, true, shown);
  };
  for (const CustomColumn& column : about_.memory) {
    add(*engine_.memory, column, "memory:", false);
  }
  for (const CustomColumn& column : about_.infos) add(*engine_.outputs, column, "info:", true);
}

// --- calls ---

void CustomTask::reset(std::span<const int> envs) {
  arrays_->call(*instance_, CustomMethod::kReset, envs);
  settle_props(envs);
}

void CustomTask::before_physics(std::span<const int> envs) {
  arrays_->call(*instance_, CustomMethod::kBeforePhysics, envs);
  settle_props(envs);
}

void CustomTask::advance(std::span<const int> envs) {
  arrays_->call(*instance_, CustomMethod::kAdvance, envs);
  settle_props(envs);
}

void CustomTask::evaluate(std::span<const int> envs) {
  arrays_->call(*instance_, CustomMethod::kEvaluate, envs);
}

void CustomTask::observe(std::span<const int> envs, FloatRows out) {
  if (info_.state_fields.empty()) return;
  arrays_->call(*instance_, CustomMethod::kObserve, envs);
  for (const int env : envs) std::copy_n(state_.row(env), state_.width(), out.row(env));
}

void CustomTask::dense_reward(std::span<const int> envs, FloatRows out) {
  arrays_->call(*instance_, CustomMethod::kReward, envs);
  for (const int env : envs) *out.row(env) = reward_[env];
}

void CustomTask::act(std::span<const int> envs, Script script, FloatRows actions) {
  const bool known = script == Script::kOracle  ? about_.has_oracle
                     : script == Script::kBlind ? about_.has_blind
                                                : about_.has_sweep;
  if (!known) refuse(info_.id, std::string("it has no ") + name_of(script));
  for (const int env : envs) {
    policy_key_[env] = engine_.policy_key(env);
    if (has_choices()) write_choice(env);
  }
  const CustomMethod method = script == Script::kOracle  ? CustomMethod::kOracle
                              : script == Script::kBlind ? CustomMethod::kBlind
                                                         : CustomMethod::kSweep;
  arrays_->call(*instance_, method, envs);
  for (const int env : envs) std::copy_n(actions_.row(env), kActionDim, actions.row(env));
}

// --- choices ---

ChoiceForm CustomTask::choice_form() const {
  const CustomChoices& choices = about_.choices;
  return {.question = choices.question,
          .items = choices.items,
          .least = choices.count,
          .most = choices.count};
}

bool CustomTask::is_choice_due(int env) const {
  const std::int32_t first = std::max(cue_end_[env], engine_.freeze_steps[env]);
  return awaits_choice(env) && engine_.state->elapsed[env] >= first;
}

void CustomTask::write_choice(int env) const {
  const std::span<const int> keys = choice(env);
  std::int32_t* row = choice_.row(env);
  std::fill_n(row, choice_.width(), -1);
  std::ranges::copy(keys, row);
}

// --- props ---

// What the engine has to know of poses that the rules have set.
void CustomTask::settle_props(std::span<const int> envs) const {
  const State& state = *engine_.state;
  for (const int env : envs) {
    for (int prop = 0; prop < state.num_props; ++prop) {
      if (state.prop_status.row(env)[prop] > static_cast<std::uint8_t>(PropStatus::kAwake)) {
        state.prop_status.row(env)[prop] = 0;
        throw Error(Error::kTaskFailed,
                    "task '" + info_.id + "': prop '" +
                        scene_.props[static_cast<std::size_t>(prop)].name +
                        "' has a status that there is not, 0 (hidden), 1 (asleep) or 2 (awake) "
                        "allowed");
      }
      std::uint8_t& moved = moved_.row(env)[prop];
      if (moved == 0) continue;
      if (moved != kOnlyContacts) {
        std::fill_n(state.finger_force.row(env) + 6 * prop, 6, 0.0);
        state.prop_slow_steps.row(env)[prop] = 0;
      }
      moved = 0;
      state.forget_contacts(env, prop);
    }
  }
}

std::string CustomTask::instruction(int env) const { return draws_.filled(info_.instruction, env); }

namespace {

[[noreturn]] void refuse_range() {
  throw Error(Error::kInternal, "a batch task was called for a range");
}

}  // namespace

void CustomTask::advance(Range /*envs*/) { refuse_range(); }
void CustomTask::evaluate(Range /*envs*/) { refuse_range(); }
void CustomTask::observe(Range /*envs*/, FloatRows /*out*/) { refuse_range(); }
void CustomTask::dense_reward(Range /*envs*/, FloatRows /*out*/) { refuse_range(); }
const Expert& CustomTask::expert() const { refuse_range(); }

}  // namespace engram::tasks
