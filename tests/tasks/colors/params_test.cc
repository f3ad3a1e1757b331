#include "tasks/colors/params.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

TEST_CASE("Candidates are the sets of colours, or their orders", "[color_recall]") {
  const auto candidates = [](const tasks::ColorRecallParams& params) {
    TaskInfo info;
    tasks::describe_color_recall(params, info);
    return info.candidates;
  };
  CHECK(candidates(tasks::kBunchVariants[1]) == 84);   // 3 of 9
  CHECK(candidates(tasks::kSeqVariants[1]) == 84);     // the order does not count
  CHECK(candidates(tasks::kChainVariants[1]) == 504);  // it does
}

TEST_CASE("A cue of all colours leaves nothing to choose", "[color_recall]") {
  tasks::ColorRecallParams params = tasks::kBunchVariants[1];
  CHECK_NOTHROW(params.check(400));
  params.COLORS = 3;
  CHECK_THROWS_WITH(params.check(400), Catch::Contains("or there is one answer only"));
}

}  // namespace
}  // namespace engram
