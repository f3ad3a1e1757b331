// Episodes of policies that name answers, without processes.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/batch/queries.h"
#include "core/task/annotator.h"
#include "protocol/eval/policies/choosing_policy.h"
#include "protocol/make/episodes.h"
#include "protocol/make/rows.h"

namespace engram::test {

inline constexpr std::uint64_t kCanonicalSeed = 4242424242;

// Answers every question by a function.
class Chooser final : public ExternalPolicy {
 public:
  using Answer = std::function<void(const ChoiceQuestion&, ChoiceAnswer&)>;
  explicit Chooser(Answer answer) : answer_(std::move(answer)) {}

  void act(const PolicyRequest& /*request*/, PolicyReply& /*reply*/) override {
    throw Error(Error::kInternal, "it names answers");
  }
  void choose(const ChoiceQuestion& question, ChoiceAnswer& answer) override {
    answer_(question, answer);
  }

 private:
  Answer answer_;
};

// The right answer of the episode in an environment, from what its annotator says: texts of items
// in their order. Privileged.
inline std::vector<std::string> right_answer(const Batch& batch, const ChoiceQuestion& question) {
  const Annotator& annotator = *Queries(batch).annotator();
  const std::string& id = batch.info().id;
  const auto plan = annotator.plan(question.slot);
  const std::string memory = annotator.memory(question.slot);
  const auto holds = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  std::vector<std::string> right;
  const auto find_in = [&](const std::string& line, std::size_t skipped) {
    for (const std::string& item : question.choices) {
      if (line.ends_with(item.substr(skipped)) || holds(line, item.substr(skipped) + " ")) {
        right.push_back(item);
      }
    }
  };
  if (id.starts_with("BlinkCount")) {  // "the lamp blinked 3 times"
    const std::string number = memory.substr(17, memory.find(' ', 17) - 17);
    return {number + (number == "1" ? " blink" : " blinks")};
  }
  if (id.starts_with("TakeItBack")) {  // "..., y = -3 cm"
    const int y = std::stoi(memory.substr(memory.find("y = ") + 4));
    return {y < 0    ? "on the left, near y -0.08 m"
            : y < 10 ? "in the middle, near y 0.03 m"
                     : "on the right, near y 0.13 m"};
  }
  if (id.starts_with("Batteries")) {  // one after the other, by place
    std::vector<std::string> sorted = Queries(batch).choices()->choice_items(question.slot);
    return {sorted[static_cast<std::size_t>(question.index)]};
  }
  for (const std::string& line : plan) {
    if (line.starts_with("touch ") || line.starts_with("push ") || line.starts_with("lift ")) {
      find_in(line, 0);
    } else if (line.starts_with("press the ") && line.ends_with(" button") &&
               id.starts_with("Gather")) {
      find_in(line, 0);
    } else if (line.starts_with("trace the ")) {
      find_in(line, 1);  // "a circle"
    }
  }
  return right;
}

struct ChoiceOutcome {
  std::vector<bool> successes;
  std::vector<bool> correct;  // first answers
  std::vector<EpisodeDigests> digests;

  double rate() const { return share(successes); }
  double answer_rate() const { return share(correct); }

 private:
  static double share(const std::vector<bool>& values) {
    return static_cast<double>(std::count(values.begin(), values.end(), true)) /
           static_cast<double>(values.size());
  }
};

struct ChoicePlay {
  std::string id;
  int episodes = 50;
  int num_envs = 50;
  int threads = 2;
  ObsMode obs_mode = ObsMode::kNone;
  int stride = 1;
  std::uint64_t first_seed = kCanonicalSeed;
  ConstantTable constants = {};
};

// `answer` gets the batch as well.
inline ChoiceOutcome play_choices(
    const ChoicePlay& play,
    const std::function<void(const Batch&, const ChoiceQuestion&, ChoiceAnswer&)>& answer) {
  const MakeOptions options{{.num_envs = std::min(play.episodes, play.num_envs),
                             .threads = play.threads,
                             .obs_mode = play.obs_mode,
                             .auto_reset = AutoReset::kOff},
                            play.constants};
  const std::unique_ptr<Batch> batch = make(play.id, options);
  const std::atomic<bool> stopped = false;
  std::atomic<std::uint64_t> steps = 0;
  const WorkContext context(0, stopped, steps);
  Chooser chooser([&](const ChoiceQuestion& question, ChoiceAnswer& reply) {
    answer(*batch, question, reply);
  });
  ChoosingPolicy policy(*batch, chooser, context, {.stride = play.stride});
  ChoiceOutcome outcome;
  const auto count = static_cast<std::size_t>(play.episodes);
  outcome.successes.resize(count);
  outcome.correct.resize(count);
  outcome.digests.resize(count);
  struct Watcher {
    Batch& batch;
    ChoosingPolicy& policy;
    ChoiceOutcome& outcome;
    std::uint64_t first_seed;

    void start(int env, int episode) {
      const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(episode);
      policy.start(env, {episode, episode, seed});
    }
    void before_step(int /*env*/, std::span<float> /*action*/) {}
    void after_step(int /*env*/) {}
    void finish(int env, int episode) {
      const auto i = static_cast<std::size_t>(episode);
      outcome.successes[i] = value_of<std::uint8_t>(batch.output("success_once"), env) != 0;
      outcome.correct[i] = value_of<std::uint8_t>(batch.output("first_answer_correct"), env) != 0;
      outcome.digests[i] = policy.digests(env);
      policy.finish(env);
    }
  };
  const auto act = [&](std::span<float> actions, std::span<std::uint8_t> commanded) {
    policy.act(actions, commanded);
  };
  play_episodes(*batch, play.first_seed, play.episodes, context, act,
                Watcher{*batch, policy, outcome, play.first_seed});
  return outcome;
}

// The ids of tasks with choices; long: those with long episodes.
inline bool is_lengthy(const RegistryEntry& entry) {
  return entry.id.find("Long") != std::string_view::npos || entry.horizon > 300;
}
inline std::vector<std::string> ids_with_choices() {
  std::vector<std::string> ids;
  for (const RegistryEntry& entry : registry()) {
    if (answer_controller_of(*make_task(entry.id)) != nullptr) ids.emplace_back(entry.id);
  }
  return ids;
}

}  // namespace engram::test
