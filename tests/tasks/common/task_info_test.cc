#include "tasks/common/task_info.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

TEST_CASE("A description begins with what the registry knows", "[parts]") {
  const RegistryEntry& entry = require_entry("RememberColor9-VLA-v0");
  const TaskInfo info = tasks::describe(entry);
  CHECK(info.id == "RememberColor9-VLA-v0");
  CHECK(info.family == "RememberColor");
  CHECK(info.horizon == entry.horizon);
  CHECK(info.canonical);
}

TEST_CASE("A scene's props are named in their order", "[parts]") {
  mjcf::Scene scene;
  scene.props = {mjcf::cube("red", 0.02, {1, 0, 0, 1}), mjcf::cube("blue", 0.02, {0, 0, 1, 1}),
                 mjcf::cube("large", 0.03, {1, 0, 0, 1})};
  const SceneSpec source = tasks::scene_source(scene);
  CHECK(source.props == std::vector<std::string>{"red", "blue", "large"});
}

}  // namespace
}  // namespace engram
