// The C API of the evaluation protocol: policies that are callbacks.
#include <mutex>
#include <optional>
#include <set>
#include <type_traits>

#include "api/c_convert.h"
#include "api/c_error.h"
#include "api/c_options.h"
#include "api/c_text.h"
#include "engram/engram_c.h"
#include "protocol/eval/evaluation_run.h"
#include "protocol/eval/policies/choice_question.h"
#include "protocol/eval/probe/probe_report.h"
#include "protocol/eval/probe/probe_run.h"
#include "protocol/eval/run/choice_tasks.h"
#include "protocol/eval/run/suites.h"
#include "protocol/io/files.h"
#include "protocol/make/environment_files.h"
#include "protocol/make/variants.h"

struct engram_policy_reply {
  engram::PolicyReply* reply;
  std::string failure;
  engram::Json identity;
};

struct engram_choice_answer {
  engram::ChoiceAnswer* answer;
  std::string failure;
};

namespace {

using engram::Error;
using engram::c::call_host;
using engram::c::convert;
using engram::c::guarded;
using engram::c::kNoLimit;

[[noreturn]] void refuse_settings(const std::string& what) {
  throw Error(Error::kInvalidArgument, what);
}

void require_success(int status, const std::string& failure) {
  if (status == 0) return;
  throw Error(Error::kUnavailable, failure.empty() ? "the policy's callback returned " +
                                                         std::to_string(status) + ", 0 needed"
                                                   : "policy: " + failure);
}

std::vector<const char*> c_texts(std::span<const std::string> texts) {
  std::vector<const char*> plain;
  plain.reserve(texts.size());
  for (const std::string& text : texts) plain.push_back(text.c_str());
  return plain;
}

// The callback as a policy. Threads share the callback; one at a time calls it.
class CallbackPolicy final : public engram::ExternalPolicy {
 public:
  CallbackPolicy(engram_policy_callback callback, void* user, std::mutex& mutex, int worker)
      : callback_(callback), user_(user), mutex_(mutex), worker_(worker) {}

  void set_identity(std::shared_ptr<engram::PolicyIdentity> identity) {
    identity_ = std::move(identity);
  }

  void act(const engram::PolicyRequest& request, engram::PolicyReply& reply) override {
    const std::string id(request.env_id);
    const std::vector<const char*> instructions = c_texts(request.instructions);
    engram_policy_request plain = {};
    plain.struct_size = sizeof plain;
    plain.env_id = id.c_str();
    plain.count = request.count;
    plain.worker = worker_;
    plain.slots = request.slots.data();
    plain.episodes = request.numbers.data();
    plain.steps = request.steps.data();
    plain.first = request.first.data();
    plain.instructions = instructions.data();
    plain.proprio = request.proprio.data();
    plain.rgb = request.rgb.empty() ? nullptr : request.rgb.data();
    plain.state = request.state.empty() ? nullptr : request.state.data();
    plain.height = request.height;
    plain.width = request.width;
    plain.state_dim = request.state_dim;
    plain.max_slots = request.max_slots;
    plain.action_dim = reply.action_dim();
    plain.seeds = request.seeds.empty() ? nullptr : request.seeds.data();
    plain.policy_seed = request.policy_seed;
    plain.proprio_dim = request.proprio_dim;
    engram_policy_reply answer{&reply, {}, {}};
    int status = 0;
    {
      const std::lock_guard lock(mutex_);
      status = call_host(callback_, user_, &plain, &answer);
    }
    require_success(status, answer.failure);
    if (identity_) identity_->take(answer.identity);
  }

 private:
  engram_policy_callback callback_;
  std::shared_ptr<engram::PolicyIdentity> identity_;
  void* user_;
  std::mutex& mutex_;
  int worker_;
};

// A policy whose callback names answers.
class ChoiceCallback final : public engram::ExternalPolicy {
 public:
  ChoiceCallback(engram_choice_callback callback, void* user, std::mutex& mutex, int worker)
      : callback_(callback), user_(user), mutex_(mutex), worker_(worker) {}

  void act(const engram::PolicyRequest& /*request*/, engram::PolicyReply& /*reply*/) override {
    throw Error(Error::kInternal, "this policy names answers and sends no actions");
  }

  void choose(const engram::ChoiceQuestion& question, engram::ChoiceAnswer& answer) override {
    const std::string id(question.env_id);
    const std::vector<const char*> choices = c_texts(question.choices);
    const std::vector<const char*> texts = c_texts(question.texts);
    engram_choice_question plain = {};
    plain.struct_size = sizeof plain;
    plain.env_id = id.c_str();
    plain.worker = worker_;
    plain.slot = question.slot;
    plain.episode = question.number;
    plain.step = question.step;
    plain.index = question.index;
    plain.instruction = question.instruction.c_str();
    plain.question = question.form.question.c_str();
    plain.choices = choices.data();
    plain.num_choices = choices.size();
    plain.least = question.form.least;
    plain.most = question.form.most;
    plain.repeats = question.form.repeats ? 1 : 0;
    plain.num_frames = question.steps.size();
    plain.frame_steps = question.steps.data();
    plain.proprio = question.proprio.data();
    plain.rgb = question.rgb.empty() ? nullptr : question.rgb.data();
    plain.state = question.state.empty() ? nullptr : question.state.data();
    plain.texts = texts.empty() ? nullptr : texts.data();
    plain.height = question.height;
    plain.width = question.width;
    plain.state_dim = question.state_dim;
    plain.proprio_dim = question.proprio_dim;
    plain.max_slots = question.max_slots;
    plain.seed = question.seed ? &*question.seed : nullptr;
    plain.policy_seed = question.policy_seed;
    engram_choice_answer reply{&answer, {}};
    int status = 0;
    {
      const std::lock_guard lock(mutex_);
      status = call_host(callback_, user_, &plain, &reply);
    }
    require_success(status, reply.failure);
  }

 private:
  engram_choice_callback callback_;
  void* user_;
  std::mutex& mutex_;
  int worker_;
};

std::vector<std::string> chosen_ids(const engram_evaluation_options& options) {
  if (options.num_ids == 0 || options.ids == nullptr)
    refuse_settings("ids: none given, 1 or more needed");
  engram::load_environment_files();
  std::set<const engram::RegistryEntry*> tasks;
  for (std::size_t i = 0; i < options.num_ids; ++i) {
    if (options.ids[i] == nullptr) refuse_settings("ids: a null pointer given");
    tasks.insert(&engram::require_entry(options.ids[i]));
  }
  return engram::ids_in_order({tasks.begin(), tasks.end()});
}

engram::Json config_of(const engram_evaluation_options& options) {
  if (options.config_json == nullptr) return engram::JsonTable();
  std::optional<engram::Json> config = engram::parse_json(options.config_json);
  if (!config || !engram::is_table(*config)) refuse_settings("config_json: a JSON object needed");
  return std::move(*config);
}

engram::ObsMode to_obs_mode(std::int32_t mode) {
  if (mode != ENGRAM_OBS_RGB && mode != ENGRAM_OBS_STATE && mode != ENGRAM_OBS_OBJECTS) {
    refuse_settings("obs_mode: " + std::to_string(mode) +
                    " given, ENGRAM_OBS_RGB, ENGRAM_OBS_STATE or ENGRAM_OBS_OBJECTS allowed");
  }
  return static_cast<engram::ObsMode>(mode);
}

// A latency; NULL: the default.
void convert(const char* what, const char* given, int& steps) {
  if (given != nullptr) steps = engram::parse_latency(what, given);
}

engram::EvaluationSettings settings_of(const engram_evaluation_options& options, bool choices) {
  engram::EvaluationSettings settings;
  engram::MakeOptions environment;
  int num_envs = 0;
  settings.tasks = chosen_ids(options);
  convert("num_envs", options.num_envs, 1, kNoLimit, num_envs);
  environment.obs_mode = to_obs_mode(options.obs_mode);
  // begin generated: conversions (tools/surface, from api/surface.toml)
  convert("episodes", options.episodes, 1, kNoLimit, settings.episodes);
  convert("seed", options.seed, settings.start_seed);
  convert("rules", options.rules, environment.rules);
  convert("tell_episodes", options.tell_episodes, settings.tell_episodes);
  convert("repeat", options.repeat, 1, engram::kMaxRepeat, settings.repeat);
  convert("policy_seed", options.policy_seed, settings.policy_seed);
  convert("latency", options.latency, settings.latency);
  convert("joint_proprio", options.joint_proprio, environment.joint_proprio);
  convert("choices_stride", options.choices_stride, 1, engram::kMaxChoicesStride,
          settings.choices_stride);
  convert("physics", options.physics, environment.physics);
  // end generated
  engram::check_rounds(settings.episodes, settings.repeat);
  if (options.name != nullptr) engram::require_custom_name("name", options.name);
  settings.policy = options.name == nullptr ? "external" : options.name;
  settings.policy_config = config_of(options);
  if (options.seed_file != nullptr) {
    if (settings.tell_episodes) refuse_settings("seed_file, tell_episodes: one of them allowed");
    settings.set_commitment(engram::SeedCommitment::read(options.seed_file));
  }
  if (options.renderer != nullptr) environment.image_options.renderer = options.renderer;
  convert("control_mode", options.control_mode, environment.control_mode);
  environment.task_options = engram::c::to_choices(options.task_options, options.num_task_options);
  environment.perturbations =
      engram::c::to_perturbations(options.perturbations, options.num_perturbations);
  engram::check_perturbations(environment.perturbations);
  if (options.constants != nullptr) {
    environment.constants = engram::parse_constants(options.constants);
  }
  settings.set_environment(environment);
  for (const std::string& id : settings.tasks) (void)engram::make_task(id, settings.constants);
  settings.choices = choices;
  if (choices) {
    engram::require_choices(settings);
  } else {
    settings.choices_stride = engram::RunOptions().choices_stride;
  }
  return settings;
}

// Texts that are there must say something: an empty path would be the folder one happens to be in.
void check_texts(const engram_evaluation_options& options) {
  const std::pair<const char*, const char*> texts[] = {{"name", options.name},
                                                       {"output", options.output},
                                                       {"resume", options.resume},
                                                       {"shard", options.shard},
                                                       {"seed_file", options.seed_file}};
  for (const auto& [what, text] : texts) {
    if (text != nullptr && *text == '\0')
      refuse_settings(std::string(what) + ": '' given, a text needed");
  }
}

engram::EvaluationRun begin_shard(const engram_evaluation_options& options, bool choices) {
  const engram::Shard shard = engram::parse_shard("shard", options.shard);
  if (options.output == nullptr || options.resume != nullptr) {
    refuse_settings("shard: given without output or with resume; output, for its folder, needed");
  }
  engram::EvaluationSettings settings = settings_of(options, choices);
  engram::ResultFolder folder = engram::ResultFolder::of_shard(options.output, shard);
  return {std::move(settings), std::move(folder), {.shard = shard}};
}

engram::EvaluationRun begin(const engram_evaluation_options& options, bool choices) {
  check_texts(options);
  if (options.shard != nullptr) return begin_shard(options, choices);
  engram::EvaluationSettings settings = settings_of(options, choices);
  std::optional<engram::ResultFolder> folder;
  if (options.resume != nullptr) {
    folder = engram::ResultFolder::open(options.resume);
    const auto before = folder->settings();
    settings.revealed = before && before->revealed;
    if (before && before->document() != settings.document()) {
      refuse_settings("resume: '" + folder->path().string() + "' was begun with other options");
    }
  } else if (options.output != nullptr) {
    folder = engram::ResultFolder::create(options.output, settings);
  }
  return {std::move(settings), std::move(folder)};
}

// With a callback as its policy. Policy, Callback: a class above and its callback. mutex: outlives
// the protocol. identity: takes what the policy tells of itself, or null.
template <class Policy, class Callback>
engram::Protocol protocol_of(const engram::EvaluationSettings& settings,
                             const engram_evaluation_options& options, Callback callback,
                             void* user, std::mutex& mutex,
                             const std::shared_ptr<engram::PolicyIdentity>& identity = nullptr) {
  engram::Protocol protocol = engram::protocol_of(settings);
  protocol.external = [=, &mutex](const engram::WorkContext& context) {
    auto policy = std::make_unique<Policy>(callback, user, mutex, context.worker());
    if constexpr (std::is_same_v<Policy, CallbackPolicy>) policy->set_identity(identity);
    return policy;
  };
  protocol.num_envs = options.num_envs;
  protocol.threads = options.threads;
  return protocol;
}

void report_progress(const engram_evaluation_options& options, void* user, int episodes, int all,
                     std::uint64_t env_steps) {
  if (options.progress == nullptr) return;
  if (call_host(options.progress, user, episodes, all, env_steps) == 0) return;
  throw Error(Error::kUnavailable, "ended by the progress callback");
}

std::string probe(const engram_evaluation_options& options, const char* probes, const char* other,
                  engram_policy_callback policy, void* user) {
  check_texts(options);
  if (options.resume != nullptr) refuse_settings("resume: given, probes have none");
  if (options.shard != nullptr) refuse_settings("shard: given, probes of a callback have none");
  const engram::EvaluationSettings settings = settings_of(options, /*choices=*/false);
  engram::ProbeOptions chosen;
  if (probes != nullptr) chosen.probes = engram::parse_probes("probes", probes);
  if (other != nullptr) chosen.other = other;
  if (options.output != nullptr) chosen.output = options.output;
  std::mutex mutex;
  const engram::Json document = engram::run_probes(
      settings, protocol_of<CallbackPolicy>(settings, options, policy, user, mutex), chosen,
      [&](int episodes, int all, std::uint64_t env_steps) {
        report_progress(options, user, episodes, all, env_steps);
      });
  if (options.output != nullptr) engram::write_probes(document, options.output);
  return engram::to_text(document);
}

template <class Policy, class Callback>
std::string evaluate(const engram_evaluation_options& options, Callback callback, void* user) {
  engram::EvaluationRun run = begin(options, std::is_same_v<Policy, ChoiceCallback>);
  std::mutex mutex;
  engram::Protocol protocol =
      protocol_of<Policy>(run.settings(), options, callback, user, mutex, run.identity());
  protocol.samples = run.folder().has_value();
  const std::vector<const engram::RegistryEntry*> tasks = run.open_tasks();
  const auto tick = [&](const engram::EvaluationStatus& status) {
    report_progress(options, user, status.episodes, status.wanted, status.env_steps);
  };
  engram::Ranks alone;
  engram::evaluate(
      alone, tasks, protocol,
      {.finished = [&run](const engram::TaskResult& result) { run.add(result); }, .tick = tick},
      run.store());
  run.finish("CPU, " + std::to_string(engram::worker_threads(options.threads, alone)) + " threads");
  return engram::to_text(run.shard() ? engram::Json(run.shard_document()) : run.document());
}

template <class Policy, class Callback>
engram_status evaluate_guarded(const char* what, const engram_evaluation_options* options,
                               Callback callback, void* user, char** document) {
  if (document != nullptr) *document = nullptr;
  return guarded([&] {
    if (options == nullptr || callback == nullptr || document == nullptr) {
      refuse_settings(std::string(what) + ": a null pointer given");
    }
    if (options->struct_size != sizeof *options) {
      refuse_settings(std::string(what) + ": options not from engram_evaluation_options_init");
    }
    *document = engram::c::new_text(evaluate<Policy>(*options, callback, user));
  });
}

}  // namespace

void engram_evaluation_options_init(engram_evaluation_options* options) {
  if (options == nullptr) return;
  *options = {};
  options->struct_size = sizeof *options;
  // begin generated: init
  options->episodes = 50;
  options->num_envs = 8;
  options->obs_mode = ENGRAM_OBS_RGB;
  options->seed = 4242424242;
  options->repeat = 1;
  options->choices_stride = 1;
  // end generated
}

engram_status engram_policy_set(engram_policy_reply* reply, int32_t row, const float* actions,
                                const int64_t* shape, int32_t ndim) {
  return guarded([&] {
    if (reply == nullptr || actions == nullptr || shape == nullptr) {
      refuse_settings("engram_policy_set: a null pointer given");
    }
    if (ndim < 1 || ndim > 3) {
      refuse_settings("engram_policy_set: " + std::to_string(ndim) +
                      " dimensions given, 1 to 3 allowed");
    }
    // Larger sizes are mistakes, and their product could overflow.
    constexpr std::int64_t kMax = 1 << 24;
    std::int64_t count = 1;
    for (int i = 0; i < ndim; ++i) {
      if (shape[i] < 0 || shape[i] > kMax)
        refuse_settings("engram_policy_set: a size out of range");
      count *= shape[i];
      if (count > kMax) refuse_settings("engram_policy_set: too many numbers");
    }
    reply->reply->set(row, {actions, static_cast<std::size_t>(count)},
                      {shape, static_cast<std::size_t>(ndim)});
  });
}

engram_status engram_policy_fail(engram_policy_reply* reply, const char* message) {
  return guarded([&] {
    if (reply == nullptr || message == nullptr)
      refuse_settings("engram_policy_fail: a null pointer given");
    reply->failure = message;
  });
}

engram_status engram_policy_identify(engram_policy_reply* reply, const char* identity) {
  return guarded([&] {
    if (reply == nullptr || identity == nullptr)
      refuse_settings("engram_policy_identify: a null pointer given");
    std::optional<engram::Json> told = engram::parse_json(identity);
    if (!told || !engram::is_table(*told))
      refuse_settings("engram_policy_identify: a JSON object needed");
    reply->identity = *std::move(told);
  });
}

const char* engram_suites_json() {
  const char* text = nullptr;
  guarded([&text] {
    static const std::string all = engram::to_text(engram::suites_document());
    text = all.c_str();
  });
  return text;
}

engram_status engram_evaluate(const engram_evaluation_options* options,
                              engram_policy_callback policy, void* user, char** document) {
  return evaluate_guarded<CallbackPolicy>("engram_evaluate", options, policy, user, document);
}

engram_status engram_evaluate_choices(const engram_evaluation_options* options,
                                      engram_choice_callback policy, void* user, char** document) {
  return evaluate_guarded<ChoiceCallback>("engram_evaluate_choices", options, policy, user,
                                          document);
}

engram_status engram_choose(engram_choice_answer* answer, const int32_t* indices, size_t count) {
  return guarded([&] {
    if (answer == nullptr || (indices == nullptr && count > 0)) {
      refuse_settings("engram_choose: a null pointer given");
    }
    answer->answer->set({indices, count});
  });
}

engram_status engram_choose_texts(engram_choice_answer* answer, const char* const* texts,
                                  size_t count) {
  return guarded([&] {
    bool null = answer == nullptr || (texts == nullptr && count > 0);
    std::vector<std::string> words;
    for (size_t i = 0; i < count && !null; ++i) {
      null = texts[i] == nullptr;
      if (!null) words.emplace_back(texts[i]);
    }
    if (null) refuse_settings("engram_choose_texts: a null pointer given");
    answer->answer->set(words);
  });
}

engram_status engram_choice_fail(engram_choice_answer* answer, const char* message) {
  return guarded([&] {
    if (answer == nullptr || message == nullptr)
      refuse_settings("engram_choice_fail: a null pointer given");
    answer->failure = message;
  });
}

engram_status engram_probe(const engram_evaluation_options* options, const char* probes,
                           const char* other, engram_policy_callback policy, void* user,
                           char** document) {
  if (document != nullptr) *document = nullptr;
  return guarded([&] {
    if (options == nullptr || policy == nullptr || document == nullptr) {
      refuse_settings("engram_probe: a null pointer given");
    }
    if (options->struct_size != sizeof *options) {
      refuse_settings("engram_probe: options not from engram_evaluation_options_init");
    }
    *document = engram::c::new_text(probe(*options, probes, other, policy, user));
  });
}
