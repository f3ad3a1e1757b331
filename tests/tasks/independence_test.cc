// Independence of the hidden quantities of tasks and of episodes.
#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/task/episode.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::make_env, test::make_running, test::row;

constexpr std::uint64_t kCanonicalSeed = 4242424242;
constexpr int kSeeds = 50;
constexpr int kManySeeds = 1000;

// What is hidden in the episodes of these seeds: the numbers of oracle_info, empty where it has
// none, or always the same ones.
using Hidden = std::vector<std::vector<int>>;
Hidden hidden(const std::string& id, std::uint64_t seed, int episodes) {
  MakeOptions options;
  options.num_envs = episodes;
  options.seed = seed;
  options.threads = 2;
  const auto batch = make_running(id, options);
  if (batch->info().oracle_dim == 0 || batch->info().oracle_is_real) return {};
  Hidden result;
  for (int i = 0; i < episodes; ++i) {
    const auto* values = row<std::int32_t>(batch->output("oracle_info"), i);
    result.emplace_back(values, values + batch->info().oracle_dim);
  }
  return result;
}

// Whether the numbers are a set or a sequence of different ones, out of more.
bool is_set(const std::string& id) {
  const std::string_view family = require_entry(id).family;
  return family.find("OfColors") != std::string_view::npos ||
         family.find("Batteries") != std::string_view::npos;
}

// How often each number occurs, and what share of episodes should have it.
struct Counts {
  std::map<int, int> count;
  double expected = 0;  // per number, of kSeeds
  int numbers = 0;
  int members = 1;  // of a set
};

// Chi-squared of memberships: the usual one where each episode has one number.
double chi_squared(const Counts& counts) {
  const double share = counts.expected / kSeeds;
  double sum = 0;
  for (const auto& [number, count] : counts.count) {
    sum += (count - counts.expected) * (count - counts.expected) / (kSeeds * share * (1 - share));
  }
  return sum * (counts.numbers - 1) / counts.numbers;
}

// The probability of at least this chi-squared (Wilson and Hilferty's approximation).
double tail(double chi, double freedom) {
  const double z =
      (std::cbrt(chi / freedom) - 1 + 2 / (9 * freedom)) / std::sqrt(2 / (9 * freedom));
  return 0.5 * std::erfc(z / std::sqrt(2));
}

Counts count(const std::string& id, const Hidden& canonical, std::size_t place,
             const std::set<int>& numbers) {
  Counts counts;
  for (const int number : numbers) counts.count[number] = 0;
  for (const std::vector<int>& values : canonical) {
    if (!is_set(id)) {
      ++counts.count[values[place]];
      continue;
    }
    for (const int value : values) ++counts.count[value];
    counts.members = static_cast<int>(values.size());
  }
  counts.numbers = static_cast<int>(numbers.size());
  counts.expected = kSeeds * static_cast<double>(counts.members) / counts.numbers;
  return counts;
}

// The numbers that occur at all.
std::set<int> numbers_of(const std::string& id, const Hidden& many, std::size_t place) {
  std::set<int> numbers;
  for (const std::vector<int>& values : many) {
    if (is_set(id)) {
      numbers.insert(values.begin(), values.end());
    } else {
      numbers.insert(values[place]);
    }
  }
  return numbers;
}

TEST_CASE("On the canonical seeds no constant answer is better than luck", "[independence]") {
  double chi = 0;
  double freedom = 0;
  int tasks = 0;
  for (const std::string& id : test::implemented_ids()) {
    const Hidden canonical = hidden(id, kCanonicalSeed, kSeeds);
    const Hidden many = canonical.empty() ? Hidden{} : hidden(id, 0, kManySeeds);
    // The length of a traced sequence varies: only the first shape is always there.
    const bool first_only = is_set(id) || id.find("TraceShape") != std::string::npos;
    const std::size_t places = canonical.empty() ? 0 : first_only ? 1 : canonical[0].size();
    for (std::size_t place = 0; place < places; ++place) {
      const std::set<int> numbers = numbers_of(id, many, place);
      const Counts counts = count(id, canonical, place, numbers);
      if (counts.numbers <= counts.members) continue;
      INFO(id << " " << place);
      CHECK(counts.count.size() == numbers.size());
      const double own = chi_squared(counts);
      CHECK(tail(own, counts.numbers - 1) > 1e-4);
      chi += own;
      freedom += counts.numbers - 1;
      ++tasks;
    }
  }
  CHECK(tasks > 80);
  // Neither too uneven nor, as if it had been arranged, too even.
  CHECK(tail(chi, freedom) > 0.01);
  CHECK(tail(chi, freedom) < 0.99);
}

TEST_CASE("Tasks with the same seeds hide different things", "[independence]") {
  std::map<std::vector<std::vector<int>>, std::string> seen;
  for (const std::string& id : test::implemented_ids()) {
    const auto values = hidden(id, kCanonicalSeed, kSeeds);
    if (values.empty() ||
        std::ranges::all_of(values, [&](const auto& one) { return one == values[0]; })) {
      continue;
    }
    INFO(id << " and " << seen[values]);
    CHECK(seen[values].empty());
    seen[values] = id;
  }
}

// In how many of many episodes two tasks with three candidates hide the same one.
int agreements(const std::string& one, const std::string& other) {
  const auto a = hidden(one, 0, kManySeeds);
  const auto b = hidden(other, 0, kManySeeds);
  int same = 0;
  for (std::size_t i = 0; i < a.size(); ++i) same += a[i] == b[i] ? 1 : 0;
  return same;
}

TEST_CASE("What one task hides says nothing about another", "[independence]") {
  const std::vector<std::string> ids = {"RememberColor3-VLA-v0", "FindImposterColor3-VLA-v0",
                                        "ShellGameTouch-VLA-v0", "ShellGamePush-VLA-v0",
                                        "RememberColor3-Long-VLA-v0"};
  const double deviation = std::sqrt(kManySeeds * (1.0 / 3) * (2.0 / 3));
  for (std::size_t i = 0; i < ids.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      INFO(ids[i] << " and " << ids[j]);
      CHECK(std::abs(agreements(ids[i], ids[j]) - kManySeeds / 3.0) < 4 * deviation);
    }
  }
}

TEST_CASE("Constants given by argument keep the streams of the id", "[independence]") {
  MakeOptions options;
  options.num_envs = kSeeds;
  const auto usual = make_env("RememberColor9-VLA-v0", options);
  options.constants = {{"CUE_PHASE_STEPS", ConstantList{3, 3}}};
  const auto changed = make_env("RememberColor9-VLA-v0", options);
  usual->reset();
  changed->reset();
  for (int i = 0; i < kSeeds; ++i) {
    CHECK(*row<std::int32_t>(usual->output("oracle_info"), i) ==
          *row<std::int32_t>(changed->output("oracle_info"), i));
  }
}

TEST_CASE("Ids that differ in a letter have streams far apart", "[independence]") {
  std::set<std::uint64_t> salts;
  for (const std::string& id : test::implemented_ids()) {
    const std::uint64_t salt = stream_salt(id);
    CHECK(salts.insert(salt).second);
    const std::uint64_t near = stream_salt(id + "0");
    CHECK(std::popcount(salt ^ near) > 10);
  }
}

}  // namespace
}  // namespace engram
