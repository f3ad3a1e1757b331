#include "protocol/eval/results/result_check.h"

#include <algorithm>
#include <charconv>
#include <limits>

namespace engram {
namespace {

constexpr std::uint64_t kMaxSteps = std::numeric_limits<std::int32_t>::max();

// The list under a key, each item as `read` takes it.
template <class T, class Read>
std::vector<T> values(const Json& document, const char* key, Read&& read) {
  std::vector<T> all;
  for (const Json& item : list(part(document, key))) all.push_back(read(item));
  return all;
}

std::vector<Answer> answers_of(const Json& document) {
  std::vector<Answer> answers;
  if (is_null(part(document, "first_answers"))) return answers;
  for (const Json& first : list(part(document, "first_answers"))) {
    Answer answer;
    if (!is_null(first)) answer = {1, static_cast<std::int32_t>(number(first)), 0};
    answers.push_back(answer);
  }
  const JsonList& correct = list(part(document, "first_answers_correct"));
  for (std::size_t i = 0; i < answers.size() && i < correct.size(); ++i) {
    answers[i].correct = truth(correct[i]) ? 1 : 0;
  }
  return answers;
}

// Nothing in results of before 0.5.0.
std::vector<Completion> completions_of(const Json& document) {
  const Json* done = find(document, "subtasks_done");
  if (done == nullptr || is_null(*done)) return {};
  const auto numbers = [&](const char* key) {
    return values<std::int32_t>(document, key, [](const Json& item) {
      return static_cast<std::int32_t>(whole_number(item, kMaxSteps));
    });
  };
  const std::vector<std::int32_t> most = numbers("subtasks_done");
  const std::vector<std::int32_t> all = numbers("subtasks");
  if (most.size() != all.size()) throw Error(Error::kIo, "subtasks are missing");
  std::vector<Completion> completions;
  for (std::size_t i = 0; i < all.size(); ++i) completions.push_back({most[i], all[i]});
  return completions;
}

std::uint64_t hash_of(const Json& document) {
  const std::string& digits = text(document);
  std::uint64_t hash = 0;
  const char* const end = digits.data() + digits.size();
  const auto [rest, error] = std::from_chars(digits.data(), end, hash, 16);
  if (error != std::errc() || rest != end) throw Error(Error::kIo, "no digest");
  return hash;
}

// Nothing in results of before 0.5.0.
std::vector<EpisodeDigests> digests_of(const Json& document) {
  const Json* all = find(document, "digests");
  if (all == nullptr || is_null(*all)) return {};
  std::vector<EpisodeDigests> digests(list(part(*all, "observations")).size());
  const auto take = [&](const char* key, std::uint64_t EpisodeDigests::*field) {
    const JsonList& texts = list(part(*all, key));
    if (texts.size() != digests.size()) throw Error(Error::kIo, "digests are missing");
    for (std::size_t i = 0; i < texts.size(); ++i) digests[i].*field = hash_of(texts[i]);
  };
  for (const auto& [key, field] : kDigestKeys) take(key, field);
  return digests;
}

TaskResult read(const Json& document, const RegistryEntry& entry) {
  TaskResult result;
  result.entry = &entry;
  result.chance = number(part(document, "chance"));
  result.successes = values<bool>(document, "successes", truth);
  result.returns = values<double>(document, "returns", number);
  result.lengths = values<int>(document, "episode_lengths", [](const Json& item) {
    return static_cast<int>(whole_number(item, kMaxSteps));
  });
  if (!is_null(part(document, "episode_seeds"))) {  // as in a sealed run
    result.seeds = values<std::uint64_t>(document, "episode_seeds",
                                         [](const Json& item) { return whole_number(item); });
  }
  result.answers = answers_of(document);
  result.completions = completions_of(document);
  result.digests = digests_of(document);
  if (!result.answers.empty()) result.answer_chance = number(part(document, "answer_chance"));
  result.chunk_size =
      static_cast<int>(whole_number(part(document, "action_chunk_size"), kMaxSteps));
  return result;
}

}  // namespace

std::optional<TaskResult> parse_result(const Json& document, const RegistryEntry& entry) {
  try {
    if (text(part(document, "env_id")) != entry.id) return std::nullopt;
    TaskResult result = read(document, entry);
    const std::size_t episodes = whole_number(part(document, "n_episodes"));
    const bool complete = result.successes.size() == episodes &&
                          result.returns.size() == episodes && result.lengths.size() == episodes &&
                          (result.seeds.empty() || result.seeds.size() == episodes) &&
                          (result.answers.empty() || result.answers.size() == episodes) &&
                          (result.completions.empty() || result.completions.size() == episodes) &&
                          (result.digests.empty() || result.digests.size() == episodes);
    if (!complete) return std::nullopt;
    return result;
  } catch (const Error&) {
    return std::nullopt;
  }
}

bool follows_protocol(const TaskResult& result, const EvaluationSettings& settings) {
  if (result.lengths.size() != static_cast<std::size_t>(settings.all_episodes())) return false;
  const auto episodes = static_cast<std::size_t>(settings.episodes);
  for (std::size_t i = 0; i < result.seeds.size(); ++i) {
    if (result.seeds[i] != settings.start_seed + i % episodes) return false;
  }
  const int horizon = settings.constants.empty()
                          ? result.entry->horizon
                          : make_task(result.entry->id, settings.constants)->info().horizon;
  return std::ranges::all_of(result.lengths,
                             [horizon](int length) { return length >= 1 && length <= horizon; });
}

}  // namespace engram
