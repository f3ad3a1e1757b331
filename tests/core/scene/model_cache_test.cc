#include "core/scene/model_cache.h"

#include <catch2/catch.hpp>
#include <memory>
#include <thread>
#include <vector>

#include "tests/core/scene/props.h"

namespace engram {
namespace {

SceneSpec one_cube(double half_size) {
  mjcf::Scene scene;
  scene.props.push_back(mjcf::cube("cube", half_size, {1, 0, 0, 1}));
  return tasks::scene_source(scene);
}

TEST_CASE("Equal scenes share a model, others do not", "[model_cache]") {
  const auto first = cached_model(one_cube(0.021));
  CHECK(cached_model(one_cube(0.021)) == first);
  CHECK(cached_model(one_cube(0.022)) != first);
}

TEST_CASE("A model is compiled anew after its last user", "[model_cache]") {
  auto first = cached_model(one_cube(0.023));
  const std::weak_ptr<const PhysicsModel> watch = first;
  first.reset();
  CHECK(watch.expired());
  CHECK(cached_model(one_cube(0.023)) != nullptr);
}

TEST_CASE("Threads that ask for the same scene at once get the same model", "[model_cache]") {
  std::vector<std::shared_ptr<const PhysicsModel>> models(4);
  std::vector<std::thread> threads;
  for (auto& model : models) threads.emplace_back([&] { model = cached_model(one_cube(0.024)); });
  for (std::thread& thread : threads) thread.join();
  for (const auto& model : models) CHECK(model == models.front());
}

}  // namespace
}  // namespace engram
