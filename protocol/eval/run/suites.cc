#include "protocol/eval/run/suites.h"

#include <algorithm>
#include <array>

#include "protocol/eval/run/evaluate.h"

namespace engram {
namespace {

// The five tasks that published VLA policies with memory are compared on.
constexpr std::array<std::string_view, 5> kMikasa5 = {
    "ShellGameTouch-VLA-v0", "InterceptMedium-VLA-v0", "RememberColor3-VLA-v0",
    "RememberColor5-VLA-v0", "RememberColor9-VLA-v0"};

constexpr Suite kSuites[] = {{"mikasa5", kMikasa5, 100}};

}  // namespace

std::string suite_names() {
  std::string names;
  for (const Suite& suite : kSuites) {
    names += (names.empty() ? "" : "|") + std::string(suite.name);
  }
  return names;
}

const Suite& require_suite(std::string_view option, std::string_view name) {
  const auto found = std::ranges::find(kSuites, name, &Suite::name);
  if (found != std::end(kSuites)) return *found;
  throw Error(Error::kInvalidArgument, std::string(option) + ": '" + std::string(name) +
                                           "' given, " + suite_names() + " allowed");
}

Json suites_document() {
  JsonTable all;
  for (const Suite& suite : kSuites) {
    JsonList ids;
    for (const std::string_view id : suite.ids) ids.emplace_back(std::string(id));
    all.emplace_back(
        suite.name,
        JsonTable{{"ids", std::move(ids)}, {"episodes", suite.episodes}, {"seed", kBenchmarkSeed}});
  }
  return all;
}

}  // namespace engram
