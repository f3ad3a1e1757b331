// Helpers of tests of the plain C API.
#pragma once

#include <catch2/catch.hpp>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "engram/engram_c.h"

namespace engram::test {

struct CloseBatch {
  void operator()(engram_env* env) const { engram_close(env); }
};
using BatchHandle = std::unique_ptr<engram_env, CloseBatch>;

inline constexpr const char* kId = "RememberColor3-VLA-v0";

inline engram_options default_options(int num_envs = 4) {
  engram_options options;
  engram_options_init(&options);
  options.num_envs = num_envs;
  options.threads = 2;
  options.seed = 11;
  return options;
}

// An evaluation of kId from the state.
inline engram_evaluation_options evaluation_options(std::int32_t episodes) {
  static constexpr const char* kIds[] = {kId};
  engram_evaluation_options options;
  engram_evaluation_options_init(&options);
  options.ids = kIds;
  options.num_ids = 1;
  options.episodes = episodes;
  options.obs_mode = ENGRAM_OBS_STATE;
  return options;
}

inline BatchHandle make_batch(const engram_options& options, const char* id = kId) {
  engram_env* env = nullptr;
  const engram_status status = engram_make(id, &options, &env);
  INFO(engram_last_error());
  REQUIRE(status == ENGRAM_OK);
  return BatchHandle(env);
}

inline BatchHandle make_batch(int num_envs = 4) { return make_batch(default_options(num_envs)); }

// A batch whose first episodes have begun.
inline BatchHandle make_running(const engram_options& options) {
  BatchHandle batch = make_batch(options);
  REQUIRE(engram_reset(batch.get(), nullptr) == ENGRAM_OK);
  return batch;
}

inline BatchHandle make_running(int num_envs = 4) {
  return make_running(default_options(num_envs));
}

inline std::size_t action_count(const BatchHandle& batch) {
  return static_cast<std::size_t>(engram_num_envs(batch.get())) *
         static_cast<std::size_t>(engram_action_dim(batch.get()));
}

inline std::vector<float> actions_of(const BatchHandle& batch, engram_policy policy) {
  std::vector<float> actions(action_count(batch));
  REQUIRE(engram_act(batch.get(), policy, actions.data(), actions.size()) == ENGRAM_OK);
  return actions;
}

// A step of one of engram's own policies.
inline void step_by(const BatchHandle& batch, engram_policy policy) {
  const std::vector<float> actions = actions_of(batch, policy);
  REQUIRE(engram_step(batch.get(), actions.data(), actions.size()) == ENGRAM_OK);
}

inline engram_array output(const BatchHandle& batch, const char* name) {
  engram_array array{};
  INFO(name);
  REQUIRE(engram_output(batch.get(), name, &array) == ENGRAM_OK);
  return array;
}

inline std::size_t size_of(const engram_array& array) {
  constexpr std::size_t kBytes[] = {1, 4, 8, 4, 8, 1};
  std::size_t size = kBytes[array.dtype];
  for (int i = 0; i < array.ndim; ++i) size *= static_cast<std::size_t>(array.shape[i]);
  return size;
}

inline std::vector<std::byte> bytes_of(const engram_array& array) {
  const auto* data = static_cast<const std::byte*>(array.data);
  return {data, data + size_of(array)};
}

// All outputs of a batch as bytes.
inline std::vector<std::byte> outputs_of(const BatchHandle& batch) {
  std::vector<std::byte> all;
  for (std::size_t i = 0; i < engram_num_outputs(batch.get()); ++i) {
    engram_array array{};
    REQUIRE(engram_output_at(batch.get(), i, &array) == ENGRAM_OK);
    const std::vector<std::byte> bytes = bytes_of(array);
    all.insert(all.end(), bytes.begin(), bytes.end());
  }
  return all;
}

template <class T>
const T* values(const engram_array& array) {
  return static_cast<const T*>(array.data);
}

// A call that must fail in this way, with a message that has this in it.
inline void check_refused(engram_status status, engram_status expected, const char* part) {
  CHECK(status == expected);
  CHECK_THAT(engram_last_error(), Catch::Matchers::Contains(part));
}

}  // namespace engram::test
