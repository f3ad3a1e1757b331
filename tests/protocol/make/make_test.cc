#include "protocol/make/make.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

constexpr const char* kId = "RememberColor9-VLA-v0";

TEST_CASE("Options of the task reach it", "[make]") {
  const MakeOptions options{{}, {{"COLORS", 4}}, 17};
  const auto batch = make(kId, options);
  CHECK(batch->info().horizon == 17);
  CHECK(batch->info().candidates == 4);
  const ConstantTable changed = changed_constants(batch->info().constants);
  REQUIRE(changed.size() == 1);
  CHECK(changed[0].first == "COLORS");
  CHECK(make(kId)->info().candidates == 9);
}

TEST_CASE("Options are checked before the task is made", "[make]") {
  MakeOptions options;
  options.max_episode_steps = -1;
  CHECK_THROWS_WITH(make("no such task", options), Catch::Contains("max_episode_steps: -1 given"));
  options.max_episode_steps = 0;
  CHECK_THROWS_WITH(make("no such task", options), Catch::Contains("did you mean"));
}

TEST_CASE("A batch's renderers are those that it was made with", "[make]") {
  int made = 0;
  MakeOptions options;
  options.obs_mode = ObsMode::kRgb;
  const RendererFactory none = [&made](const RenderScene&, const ImageSourceOptions&,
                                       int) -> std::unique_ptr<Renderer> {
    ++made;
    throw Error(Error::kUnavailable, "no such renderer");
  };
  CHECK_THROWS_WITH(make(kId, options, none), Catch::Contains("no such renderer"));
  CHECK(made == 1);
}

}  // namespace
}  // namespace engram
