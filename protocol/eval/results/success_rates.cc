#include "protocol/eval/results/success_rates.h"

#include "protocol/io/decimal.h"

namespace engram {
namespace {

constexpr std::uint64_t kMostRepeats = 1'000'000;

std::vector<bool> successes_of(const Document& task) {
  std::vector<bool> successes;
  for (const Document& success : list(part(task, "successes"))) successes.push_back(truth(success));
  return successes;
}

double independent_episodes(const Document& task) {
  return effective_episodes(successes_of(task), repeats_of(task));
}

}  // namespace

int repeats_of(const Document& task) {
  const Document* repeats = find(task, "repeat");
  if (repeats == nullptr) return 1;
  return std::max(1, static_cast<int>(whole_number(*repeats, kMostRepeats)));
}

SuccessRate success_rate(const Document& task) {
  const double rate = number(part(task, "sr"));
  return {rate, wilson_interval(rate, independent_episodes(task)), 1,
          static_cast<int>(list(part(task, "successes")).size())};
}

SuccessRate mean_success_rate(const DocumentList& tasks) {
  SuccessRate mean;
  double independent = 0;
  for (const Document& task : tasks) {
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

std::map<std::string, SuccessRate> success_rates_by(const char* key, const DocumentList& tasks) {
  std::map<std::string, DocumentList> groups;
  for (const Document& task : tasks) groups[text(part(task, key))].push_back(task);
  std::map<std::string, SuccessRate> rates;
  for (const auto& [name, members] : groups) rates[name] = mean_success_rate(members);
  return rates;
}

Document to_document(const Interval& interval) { return DocumentList{interval.low, interval.high}; }

std::string to_text(const Interval& interval) {
  return decimal(interval.low, 2) + "-" + decimal(interval.high, 2);
}

}  // namespace engram
