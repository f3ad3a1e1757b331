#include "protocol/eval/results/comparison.h"

#include <algorithm>
#include <map>
#include <optional>

#include "protocol/eval/policies/episode_digests.h"
#include "protocol/eval/results/statistics.h"
#include "protocol/eval/results/success_rates.h"
#include "protocol/io/json_values.h"
#include "protocol/make/definitions.h"
#include "protocol/make/physics_keys.h"

namespace engram {
namespace {

[[noreturn]] void refuse(const std::string& what) { throw Error(Error::kInvalidArgument, what); }

const std::string& id_of(const Json& task) { return text(part(task, "env_id")); }

// --- episodes that pair ---

// An episode by its seed, and by its round where episodes are repeated.
using EpisodeKey = std::pair<std::uint64_t, std::size_t>;

std::map<EpisodeKey, std::size_t> episodes_of(const ResultSet& results, const Json& task) {
  const Json& seeds = part(task, "episode_seeds");
  if (is_null(seeds)) {
    refuse("'" + results.source + "' is sealed, and its seeds are not known; open it first");
  }
  const std::size_t count = list(seeds).size();
  const std::size_t rounds = static_cast<std::size_t>(repeats_of(task));
  const std::size_t per_round = std::max<std::size_t>(1, count / rounds);
  std::map<EpisodeKey, std::size_t> episodes;
  for (std::size_t i = 0; i < count; ++i) {
    episodes.emplace(EpisodeKey(whole_number(list(seeds)[i]), i / per_round), i);
  }
  return episodes;
}

// Paired episodes of one task, or of several.
struct Pairs {
  PairCounts counts;
  std::vector<int> differences;  // of each seed: successes of A minus those of B
  std::size_t rounds = 1;
  // Pairs whose digests are alike, in the order of kDigestKeys; nothing where there are none.
  std::optional<std::array<int, std::size(kDigestKeys)>> alike;
  int tasks = 0;

  void add(const Pairs& more) {
    counts.both += more.counts.both;
    counts.only_a += more.counts.only_a;
    counts.only_b += more.counts.only_b;
    counts.neither += more.counts.neither;
    differences.insert(differences.end(), more.differences.begin(), more.differences.end());
    rounds = std::max(rounds, more.rounds);
    if (tasks == 0)
      alike = more.alike;
    else if (alike && more.alike) {
      for (std::size_t i = 0; i < alike->size(); ++i) (*alike)[i] += (*more.alike)[i];
    } else {
      alike.reset();
    }
    tasks += more.tasks;
  }
};

void count_pair(bool a, bool b, PairCounts& counts) {
  int& count = a ? (b ? counts.both : counts.only_a) : (b ? counts.only_b : counts.neither);
  ++count;
}

// True if both tasks have digests.
bool have_digests(const Json& a, const Json& b) {
  return !is_null(value_or_null(a, "digests")) && !is_null(value_or_null(b, "digests"));
}

Pairs pairs_of(const ResultSet& set_a, const Json& a, const ResultSet& set_b, const Json& b,
               bool common_seeds) {
  const auto episodes_a = episodes_of(set_a, a);
  const auto episodes_b = episodes_of(set_b, b);
  Pairs pairs;
  pairs.tasks = 1;
  if (have_digests(a, b)) pairs.alike.emplace();
  std::map<std::uint64_t, int> difference_of;
  for (const auto& [key, i] : episodes_a) {
    const auto other = episodes_b.find(key);
    if (other == episodes_b.end()) continue;
    const std::size_t k = other->second;
    const bool success_a = truth(list(part(a, "successes"))[i]);
    const bool success_b = truth(list(part(b, "successes"))[k]);
    count_pair(success_a, success_b, pairs.counts);
    difference_of[key.first] += static_cast<int>(success_a) - static_cast<int>(success_b);
    pairs.rounds = std::max(pairs.rounds, key.second + 1);
    if (!pairs.alike) continue;
    for (std::size_t d = 0; d < pairs.alike->size(); ++d) {
      const char* name = kDigestKeys[d].first;
      const bool same =
          list(part(part(a, "digests"), name)).at(i) == list(part(part(b, "digests"), name)).at(k);
      (*pairs.alike)[d] += same ? 1 : 0;
    }
  }
  for (const auto& [seed, difference] : difference_of) pairs.differences.push_back(difference);
  const auto paired = static_cast<std::size_t>(pairs.counts.total());
  const bool all = paired == episodes_a.size() && paired == episodes_b.size();
  if (paired == 0 || (!all && !common_seeds)) {
    refuse("the seeds of " + id_of(a) + " do not pair: " + std::to_string(episodes_a.size()) +
           " episodes in '" + set_a.source + "', " + std::to_string(episodes_b.size()) + " in '" +
           set_b.source + "', " + std::to_string(paired) + " of them in both" +
           (paired == 0 ? "" : "; allow seeds to compare those"));
  }
  return pairs;
}

// --- statistics ---

Json or_null(std::optional<double> value) { return value ? Json(*value) : Json(); }

double p_value(const Pairs& pairs) {
  return pairs.rounds == 1 ? mcnemar_p_value(pairs.counts.only_a, pairs.counts.only_b)
                           : sign_flip_p_value(pairs.differences);
}

// Rounds of an episode are not independent: then the seeds are what is counted.
JsonTable statistics(const Pairs& pairs) {
  const PairCounts& counts = pairs.counts;
  const double n = counts.total();
  const auto seeds = static_cast<int>(pairs.differences.size());
  const auto rounds = static_cast<double>(pairs.rounds);
  const bool once = pairs.rounds == 1;
  Interval interval = once ? paired_interval(counts) : mean_interval(pairs.differences, rounds);
  if (!once) interval = {interval.low / rounds, interval.high / rounds};
  std::optional<double> smallest = smallest_difference(seeds);
  if (smallest) *smallest /= rounds;
  Json alike;
  if (pairs.alike) {
    JsonTable numbers;
    for (std::size_t i = 0; i < pairs.alike->size(); ++i) {
      numbers.emplace_back(kDigestKeys[i].first, (*pairs.alike)[i]);
    }
    alike = std::move(numbers);
  }
  return {
      {"pairs", counts.total()},
      {"sr_a", (counts.both + counts.only_a) / n},
      {"sr_b", (counts.both + counts.only_b) / n},
      {"difference", (counts.only_a - counts.only_b) / n},
      {"difference_interval", to_document(interval)},
      {"p_value", p_value(pairs)},
      {"test", once ? "exact McNemar" : "exact sign flips of seeds"},
      {"both", counts.both},
      {"only_a", counts.only_a},
      {"only_b", counts.only_b},
      {"neither", counts.neither},
      {"smallest_difference", or_null(smallest)},
      {"detectable_difference",
       once ? or_null(detectable_difference(seeds, (counts.only_a + counts.only_b) / n)) : Json()},
      {"same_digests", std::move(alike)}};
}

// Holm's correction of p-values for as many tests.
std::vector<double> holm(const std::vector<double>& p_values) {
  std::vector<std::size_t> order(p_values.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return p_values[i]; });
  std::vector<double> corrected(p_values.size());
  double most = 0;
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    const auto tests = static_cast<double>(order.size() - rank);
    most = std::max(most, std::min(1.0, tests * p_values[order[rank]]));
    corrected[order[rank]] = most;
  }
  return corrected;
}

// --- which results may be compared ---

// Constants, options and perturbations of the task that a result is of.
Json environment_of(const Json& task) {
  const Json* config = find(part(task, "model"), "config");
  const Json* options = config == nullptr ? nullptr : find(*config, "task_options");
  return JsonTable{{"variant", value_or_null(task, "variant")},
                   {"task_options", options == nullptr ? Json() : *options},
                   {"perturbations", value_or_null(task, "perturbations")}};
}

// The value of a key that not all results have.
Json value_or(const Json& task, const char* key, Json missing) {
  const Json* value = find(task, key);
  return value == nullptr ? missing : *value;
}

Json compared(AllowedDifference what, const Json& task) {
  switch (what) {
    case AllowedDifference::kVersion:
      return part(task, "version");
    case AllowedDifference::kRules:
      return part(task, "rules");
    case AllowedDifference::kConstants:
      return environment_of(task);
    case AllowedDifference::kChoices:
      return value_or(task, "choices", false);
    case AllowedDifference::kPhysics:
      return physics_text(task);
    case AllowedDifference::kIds:
    case AllowedDifference::kSeeds:
      break;
  }
  return {};
}

class Comparison {
 public:
  Comparison(const ResultSet& a, const ResultSet& b, const std::set<AllowedDifference>& allowed)
      : a_(a), b_(b), allowed_(allowed) {}

  Json document() {
    JsonList tasks;
    std::vector<double> p_values;
    std::map<std::string, Pairs> splits;
    Pairs total;
    for (const auto& [a, b] : paired_tasks()) {
      check_environments(*a, *b);
      const Pairs pairs = pairs_of(a_, *a, b_, *b, allowed_.contains(AllowedDifference::kSeeds));
      splits[text(part(*a, "split"))].add(pairs);
      total.add(pairs);
      JsonTable task{{"env_id", id_of(*a)}, {"split", part(*a, "split")}};
      std::ranges::move(statistics(pairs), std::back_inserter(task));
      p_values.push_back(p_value(pairs));
      tasks.emplace_back(std::move(task));
    }
    const std::vector<double> corrected = holm(p_values);
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      std::get<JsonTable>(tasks[i].value).emplace_back("p_value_holm", corrected[i]);
    }
    JsonTable per_split;
    for (const auto& [name, pairs] : splits) per_split.emplace_back(name, group(pairs));
    return JsonTable{{"a", description(a_)},
                     {"b", description(b_)},
                     {"tasks", std::move(tasks)},
                     {"splits", std::move(per_split)},
                     {"total", group(total)}};
  }

 private:
  using TaskPair = std::pair<const Json*, const Json*>;

  static const Json* find_task(const ResultSet& results, const std::string& id) {
    const auto found = std::ranges::find(results.tasks, id, id_of);
    return found == results.tasks.end() ? nullptr : &*found;
  }

  std::vector<TaskPair> paired_tasks() const {
    std::vector<TaskPair> pairs;
    for (const Json& task : a_.tasks) {
      if (const Json* other = find_task(b_, id_of(task))) pairs.emplace_back(&task, other);
    }
    if (pairs.empty()) {
      refuse("'" + a_.source + "' and '" + b_.source + "' have no task in common");
    }
    if (allowed_.contains(AllowedDifference::kIds)) return pairs;
    require_tasks_of(a_, b_);
    require_tasks_of(b_, a_);
    return pairs;
  }

  static void require_tasks_of(const ResultSet& one, const ResultSet& other) {
    for (const Json& task : one.tasks) {
      if (find_task(other, id_of(task)) != nullptr) continue;
      refuse("'" + one.source + "' has " + id_of(task) + ", and '" + other.source +
             "' has not; allow ids to compare the tasks of both");
    }
  }

  void check_environments(const Json& a, const Json& b) const {
    if (!allowed_.contains(AllowedDifference::kConstants)) {
      require_same_definition(id_of(a), value_or_null(a, "definition"), "'" + a_.source + "'",
                              value_or_null(b, "definition"), "'" + b_.source + "'");
    }
    for (const AllowedDifference what :
         {AllowedDifference::kVersion, AllowedDifference::kRules, AllowedDifference::kConstants,
          AllowedDifference::kChoices, AllowedDifference::kPhysics}) {
      const Json of_a = compared(what, a);
      const Json of_b = compared(what, b);
      if (of_a == of_b || allowed_.contains(what)) continue;
      refuse(id_of(a) + ": " + name_of(what) + " " + to_line(of_a) + " in '" + a_.source + "', " +
             to_line(of_b) + " in '" + b_.source + "'; allow " + name_of(what) +
             " to compare them nevertheless");
    }
  }

  static Json group(const Pairs& pairs) {
    JsonTable document{{"n_tasks", pairs.tasks}};
    std::ranges::move(statistics(pairs), std::back_inserter(document));
    return document;
  }

  // Facts about results beside their numbers.
  static Json description(const ResultSet& results) {
    const Json& task = results.tasks.front();
    return JsonTable{
        {"source", results.source},           {"model", part(part(task, "model"), "name")},
        {"version", part(task, "version")},   {"rules", part(task, "rules")},
        {"obs_mode", part(task, "obs_mode")}, {"latency_steps", value_or(task, "latency_steps", 0)},
        {"repeat", repeats_of(task)},         {kPhysicsKey, physics_in(task)}};
  }

  const ResultSet& a_;
  const ResultSet& b_;
  const std::set<AllowedDifference>& allowed_;
};

}  // namespace

Json compare_results(const ResultSet& a, const ResultSet& b,
                     const std::set<AllowedDifference>& allowed) {
  return Comparison(a, b, allowed).document();
}

}  // namespace engram
