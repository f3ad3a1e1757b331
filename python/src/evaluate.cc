#include "evaluate.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <deque>
#include <initializer_list>
#include <memory>
#include <mutex>

#include "batch.h"
#include "calls.h"
#include "fields.h"

namespace engram_python {
namespace {

using Chunk = nb::ndarray<const float, nb::c_contig, nb::device::cpu>;

// A copy of the request's memory, because the policy may keep it.
template <class T>
nb::object array(const T* data, std::initializer_list<std::size_t> shape) {
  if (data == nullptr) return nb::none();
  return nb::cast(nb::ndarray<nb::numpy, const T>(data, shape.size(), shape.begin(), nb::none()),
                  nb::rv_policy::copy);
}

// Both callbacks of one evaluation, and the first exception that came out of either.
class Session {
 public:
  // policy: sends actions, or names answers. identity: returns what it is as JSON, or an empty text
  // as long as that is not known; or none.
  Session(nb::callable policy, nb::object progress, nb::object identity = nb::none())
      : policy_(std::move(policy)),
        progress_(std::move(progress)),
        identity_(std::move(identity)) {}

  static int act(void* self, const engram_policy_request* request, engram_policy_reply* reply) {
    if (calls_have_ended()) return 1;
    const Locked locked;
    return static_cast<Session*>(self)->answer(*request, reply);
  }

  static int choose(void* self, const engram_choice_question* question,
                    engram_choice_answer* answer) {
    if (calls_have_ended()) return 1;
    const Locked locked;
    return static_cast<Session*>(self)->name_answer(*question, answer);
  }

  static int report(void* self, int32_t episodes, int32_t all, uint64_t env_steps) {
    if (calls_have_ended()) return 1;
    const Locked locked;
    return static_cast<Session*>(self)->guarded([&] {
      // Ctrl-C reaches Python here: this is the thread that evaluates.
      if (unless_ended([] { return PyErr_CheckSignals(); }) != 0) nb::raise_python_error();
      nb::object& progress = static_cast<Session*>(self)->progress_;
      if (progress.is_none()) return;
      unless_ended([&] { progress(episodes, all, env_steps); });
    });
  }

  // Raises what a callback raised, if one did.
  void rethrow() {
    if (error_) throw nb::python_error(std::move(*error_));
  }

 private:
  int answer(const engram_policy_request& request, engram_policy_reply* reply) {
    return guarded([&] {
      const auto count = static_cast<std::size_t>(request.count);
      nb::dict observation;
      observation["env_id"] = request.env_id;
      observation["worker"] = request.worker;
      observation["slot"] = array(request.slots, {count});
      observation["episode"] = array(request.episodes, {count});
      if (request.seeds != nullptr) observation["seed"] = array(request.seeds, {count});
      observation["step"] = array(request.steps, {count});
      observation["policy_seed"] = request.policy_seed;
      observation["first"] = array(request.first, {count});
      nb::list instructions;
      for (std::size_t i = 0; i < count; ++i) instructions.append(request.instructions[i]);
      observation["instruction"] = instructions;
      observation["proprio"] =
          array(request.proprio, {count, static_cast<std::size_t>(request.proprio_dim)});
      observation["rgb"] = array(request.rgb, {count, static_cast<std::size_t>(request.height),
                                               static_cast<std::size_t>(request.width), 6});
      observation["state"] =
          array(request.state, {count, static_cast<std::size_t>(request.state_dim)});
      const nb::object answer = unless_ended([&] { return policy_(observation); });
      const auto chunks = nb::cast<std::vector<Chunk>>(answer);
      for (std::size_t row = 0; row < chunks.size(); ++row) {
        const Chunk& chunk = chunks[row];
        const engram_status status =
            engram_policy_set(reply, static_cast<int32_t>(row), chunk.data(), chunk.shape_ptr(),
                              static_cast<int32_t>(chunk.ndim()));
        if (status != ENGRAM_OK) raise(status, engram_last_error());
      }
      identify(reply);
    });
  }

  void identify(engram_policy_reply* reply) {
    if (identity_.is_none()) return;
    const auto told = nb::cast<std::string>(unless_ended([&] { return identity_(); }));
    if (told.empty()) return;
    const engram_status status = engram_policy_identify(reply, c_text(told));
    if (status != ENGRAM_OK) raise(status, engram_last_error());
    identity_ = nb::none();
  }

  int name_answer(const engram_choice_question& question, engram_choice_answer* answer) {
    return guarded([&] {
      const std::size_t frames = question.num_frames;
      nb::dict asked;
      asked["env_id"] = question.env_id;
      asked["worker"] = question.worker;
      asked["slot"] = question.slot;
      asked["episode"] = question.episode;
      if (question.seed != nullptr) asked["seed"] = *question.seed;
      asked["step"] = question.step;
      asked["index"] = question.index;
      asked["policy_seed"] = question.policy_seed;
      asked["instruction"] = question.instruction;
      asked["question"] = question.question;
      asked["choices"] = texts(question.choices, question.num_choices);
      asked["least"] = question.least;
      asked["most"] = question.most;
      asked["repeats"] = question.repeats != 0;
      asked["steps"] = array(question.frame_steps, {frames});
      asked["proprio"] =
          array(question.proprio, {frames, static_cast<std::size_t>(question.proprio_dim)});
      asked["rgb"] = array(question.rgb, {frames, static_cast<std::size_t>(question.height),
                                          static_cast<std::size_t>(question.width), 6});
      asked["state"] =
          array(question.state, {frames, static_cast<std::size_t>(question.state_dim)});
      asked["text"] = question.texts == nullptr ? nb::none() : texts(question.texts, frames);
      const nb::object named = unless_ended([&] { return policy_(asked); });
      const auto words = nb::cast<std::vector<std::string>>(named);
      std::vector<const char*> plain;
      for (const std::string& word : words) plain.push_back(c_text(word));
      const engram_status status = engram_choose_texts(answer, plain.data(), plain.size());
      if (status != ENGRAM_OK) raise(status, engram_last_error());
    });
  }

  static nb::object texts(const char* const* words, std::size_t count) {
    nb::list list;
    for (std::size_t i = 0; i < count; ++i) list.append(words[i]);
    return list;
  }

  template <class F>
  int guarded(F&& f) {
    try {
      f();
      return 0;
    } catch (nb::python_error& error) {
      if (!error_) error_ = std::make_unique<nb::python_error>(std::move(error));
    } catch (const std::exception& error) {
      // Raised as a Python exception, so that there is one way out.
      PyErr_SetString(PyExc_TypeError, error.what());
      if (!error_) error_ = std::make_unique<nb::python_error>();
    }
    return 1;
  }

  nb::callable policy_;
  nb::object progress_;
  nb::object identity_;
  std::unique_ptr<nb::python_error> error_;
};

// Options of an evaluation, with what engram_evaluation_options points to.
struct EvaluationOptions {
  engram_evaluation_options plain;
  std::deque<std::string> texts;
  std::vector<std::string> ids;
  NamedValue task_options;
  NamedValue perturbations;

  EvaluationOptions() { engram_evaluation_options_init(&plain); }
  EvaluationOptions(const EvaluationOptions&) = delete;
  EvaluationOptions& operator=(const EvaluationOptions&) = delete;
};

// Calls f with the options as the C API takes them.
template <class F>
std::string with_options(const EvaluationOptions& given, F&& f) {
  engram_evaluation_options options = given.plain;
  std::vector<const char*> ids;
  for (const std::string& id : given.ids) ids.push_back(c_text(id));
  options.ids = ids.data();
  options.num_ids = ids.size();
  const std::vector<engram_task_option> task_options = as_task_options(given.task_options);
  options.task_options = task_options.data();
  options.num_task_options = task_options.size();
  const std::vector<engram_perturbation> perturbations = as_perturbations(given.perturbations);
  options.perturbations = perturbations.data();
  options.num_perturbations = perturbations.size();
  options.progress = &Session::report;
  return f(options);
}

// The text of a call of the library, which it owns. before_check: is called once it has returned.
template <class Call, class Before>
std::string text_of(Call&& call, Before&& before_check) {
  char* text = nullptr;
  engram_status status = ENGRAM_OK;
  without_lock([&] { status = call(&text); });
  const std::unique_ptr<char, void (*)(char*)> owner(text, &engram_free_text);
  before_check();
  if (status != ENGRAM_OK) raise(status, engram_last_error());
  return text;
}

template <class Call>
std::string text_of(Call&& call) {
  return text_of(std::forward<Call>(call), [] {});
}

// The document of a call that asks the session's policy, whose own error comes first.
template <class Call>
std::string document_of(Session& session, Call&& call) {
  return text_of(std::forward<Call>(call), [&session] { session.rethrow(); });
}

// choices: the policy names answers.
std::string evaluate(nb::callable policy, const EvaluationOptions& given, nb::object progress,
                     bool choices, nb::object identity) {
  Session session(std::move(policy), std::move(progress), std::move(identity));
  return with_options(given, [&](const engram_evaluation_options& options) {
    return document_of(session, [&](char** document) {
      return choices ? engram_evaluate_choices(&options, &Session::choose, &session, document)
                     : engram_evaluate(&options, &Session::act, &session, document);
    });
  });
}

std::string probe(nb::callable policy, const EvaluationOptions& given, nb::object progress,
                  const std::string& probes, const std::optional<std::string>& other) {
  Session session(std::move(policy), std::move(progress));
  const char* const which = c_text(probes);
  const char* const task = other ? c_text(*other) : nullptr;
  return with_options(given, [&](const engram_evaluation_options& options) {
    return document_of(session, [&](char** document) {
      return engram_probe(&options, which, task, &Session::act, &session, document);
    });
  });
}

std::string merge(const std::vector<std::string>& folders,
                  const std::optional<std::string>& output) {
  std::vector<const char*> plain;
  for (const std::string& folder : folders) plain.push_back(c_text(folder));
  const char* const out = output ? c_text(*output) : nullptr;
  return text_of([&plain, out](char** document) {
    return engram_merge(plain.data(), plain.size(), out, document);
  });
}

std::string compare(const std::string& a, const std::string& b,
                    const std::vector<std::string>& allow) {
  std::vector<const char*> allowed;
  for (const std::string& what : allow) allowed.push_back(c_text(what));
  return text_of([&, first = c_text(a), second = c_text(b)](char** text) {
    return engram_compare(first, second, allowed.data(), allowed.size(), text);
  });
}

std::string report(const std::string& results, const std::string& format) {
  return text_of([source = c_text(results), name = c_text(format)](char** text) {
    return engram_report(source, name, text);
  });
}

}  // namespace

void bind_evaluate(nb::module_& module) {
  using namespace nb::literals;  // NOLINT: the way in which nanobind's literals are meant to be
                                 // used
  nb::class_<EvaluationOptions> options(module, "EvaluationOptions",
                                        "What is evaluated, and how: engram_evaluation_options.");
  options.def(nb::init<>());
  const auto field = field_binder(options);
  // begin generated: bindings (tools/surface, from api/surface.toml)
  field("episodes", &engram_evaluation_options::episodes);
  field("num_envs", &engram_evaluation_options::num_envs);
  field("threads", &engram_evaluation_options::threads);
  field("obs_mode", &engram_evaluation_options::obs_mode);
  field("seed", &engram_evaluation_options::seed);
  field("name", &engram_evaluation_options::name);
  field("config_json", &engram_evaluation_options::config_json);
  field("renderer", &engram_evaluation_options::renderer);
  field("output", &engram_evaluation_options::output);
  field("resume", &engram_evaluation_options::resume);
  field("rules", &engram_evaluation_options::rules);
  field("tell_episodes", &engram_evaluation_options::tell_episodes);
  field("seed_file", &engram_evaluation_options::seed_file);
  field("repeat", &engram_evaluation_options::repeat);
  field("policy_seed", &engram_evaluation_options::policy_seed);
  field("latency", &engram_evaluation_options::latency);
  field("control_mode", &engram_evaluation_options::control_mode);
  field("joint_proprio", &engram_evaluation_options::joint_proprio);
  field("choices_stride", &engram_evaluation_options::choices_stride);
  field("physics", &engram_evaluation_options::physics);
  field("shard", &engram_evaluation_options::shard);
  field("constants", &engram_evaluation_options::constants);
  // end generated
  options.def_rw("ids", &EvaluationOptions::ids)
      .def_rw("task_options", &EvaluationOptions::task_options)
      .def_rw("perturbations", &EvaluationOptions::perturbations);
  module.def("evaluate", &evaluate, "policy"_a, "options"_a, "progress"_a.none(), "choices"_a,
             "identity"_a);
  module.def("probe", &probe, "policy"_a, "options"_a, "progress"_a.none(), "probes"_a,
             "other"_a.none());
  module.def("suites_json", [] {
    const char* text = engram_suites_json();
    if (text == nullptr) raise(ENGRAM_UNAVAILABLE, engram_last_error());
    return std::string(text);
  });
  module.def("merge", &merge, "folders"_a, "output"_a.none());
  module.def("compare", &compare, "a"_a, "b"_a, "allow"_a);
  module.def("report", &report, "results"_a, "format"_a);
}

}  // namespace engram_python
