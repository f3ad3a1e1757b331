#include "protocol/eval/results/success_rates.h"

#include "protocol/io/decimal.h"

namespace engram {
namespace {

constexpr std::uint64_t kMaxRepeats = 1'000'000;

std::vector<bool> successes_of(const Json& task) {
  std::vector<bool> successes;
  for (const Json& success : list(part(task, "successes"))) successes.push_back(truth(success));
  return successes;
}

double independent_episodes(const Json& task) {
  return effective_episodes(successes_of(task), repeats_of(task));
}

}  // namespace

int repeats_of(const Json& task) {
  const Json* repeats = find(task, "repeat");
  if (repeats == nullptr) return 1;
  return std::max(1, static_cast<int>(whole_number(*repeats, kMaxRepeats)));
}

SuccessRate success_rate(const Json& task) {
  const double rate = number(part(task, "sr"));
  return {rate, wilson_interval(rate, independent_episodes(task)), 1,
          static_cast<int>(list(part(task, "successes")).size())};
}

SuccessRate mean_success_rate(const JsonList& tasks) {
  SuccessRate mean;
  double independent = 0;
  for (const Json& task : tasks) {
    const SuccessRate one = success_rate(task);
    mean.rate += one.rate;
    mean.episodes += one.episodes;
    independent += independent_episodes(task);
    ++mean.tasks;
  }
  if (mean.tasks > 0) mean.rate /= mean.tasks;
  mean.interval = wilson_interval(mean.rate, independent);
  return mean;
}

std::map<std::string, SuccessRate> success_rates_by(const char* key, const JsonList& tasks) {
  std::map<std::string, JsonList> groups;
  for (const Json& task : tasks) groups[text(part(task, key))].push_back(task);
  std::map<std::string, SuccessRate> rates;
  for (const auto& [name, members] : groups) rates[name] = mean_success_rate(members);
  return rates;
}

Json to_document(const Interval& interval) { return JsonList{interval.low, interval.high}; }

std::string to_text(const Interval& interval) {
  return decimal(interval.low, 2) + "-" + decimal(interval.high, 2);
}

}  // namespace engram
