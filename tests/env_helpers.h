// Helpers of tests that run environments.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/batch/batch.h"
#include "core/batch/scripted_policy.h"
#include "tasks/registry.h"

namespace engram::test {

// Without a renderer.
inline std::unique_ptr<Batch> make_env(std::string_view id, const BatchOptions& options = {}) {
  return std::make_unique<Batch>(make_task(id), options);
}
inline std::unique_ptr<Batch> make_env(std::string_view id, const MakeOptions& options) {
  const BatchOptions& of_batch = options;
  return std::make_unique<Batch>(make_task(id, options.constants, options.max_episode_steps),
                                 of_batch);
}
// An episode has begun.
template <class Options = BatchOptions>
std::unique_ptr<Batch> make_running(std::string_view id, const Options& options = {}) {
  auto batch = make_env(id, options);
  batch->reset();
  return batch;
}

// The ids of all tasks, or of those of one family.
inline std::vector<std::string> implemented_ids(std::string_view family = {}) {
  std::vector<std::string> ids;
  for (const RegistryEntry& entry : registry()) {
    if (family.empty() || entry.family == family) ids.emplace_back(entry.id);
  }
  return ids;
}

// The ids of one family's VLA tasks, or of its RL tasks.
inline std::vector<std::string> vla_ids(std::string_view family) {
  std::vector<std::string> ids = implemented_ids(family);
  std::erase_if(ids, [](const auto& id) { return require_entry(id).split == Split::kRl; });
  return ids;
}
inline std::vector<std::string> rl_ids(std::string_view family) {
  std::vector<std::string> ids = implemented_ids(family);
  std::erase_if(ids, [](const auto& id) { return require_entry(id).split != Split::kRl; });
  return ids;
}

// Columns of all that environments remember, and of all that they show.
inline const ColumnStore& memory_of(const Batch& batch) { return BatchAccess::data(batch).memory; }
inline const ColumnStore& columns_of(const Batch& batch) {
  return BatchAccess::data(batch).outputs;
}

// Images at the end of the last episodes.
inline ObservedImages final_images(const Batch& batch) {
  const ImageBatch* const images = BatchAccess::data(batch).images.get();
  if (images == nullptr) return {};
  return {images->rgb().finals(), images->depth().finals(), images->segmentation().finals(), {}};
}

using Bytes = std::vector<std::byte>;

inline void append_row(const ColumnStore& store, int env, Bytes& bytes) {
  Bytes saved(store.row_bytes());
  store.save_row(env, saved);
  bytes.insert(bytes.end(), saved.begin(), saved.end());
}

// Everything that one environment remembers and shows.
inline Bytes env_bytes(const Batch& batch, int index) {
  Bytes bytes;
  append_row(memory_of(batch), index, bytes);
  append_row(columns_of(batch), index, bytes);
  return bytes;
}

// Bytes of all environments, one after another.
inline Bytes batch_bytes(const Batch& batch) {
  Bytes bytes;
  for (int i = 0; i < batch.num_envs(); ++i) {
    append_row(memory_of(batch), i, bytes);
    append_row(columns_of(batch), i, bytes);
  }
  return bytes;
}

// One environment's values of an output or memory column.
template <class T>
const T* row(const ColumnView& view, int env) {
  return reinterpret_cast<const T*>(view.row(env));
}

// A truth value of the first environment.
inline bool flag(const Batch& batch, const char* name) {
  return *row<std::uint8_t>(batch.output(name), 0) != 0;
}

inline std::vector<float> zeros(const Batch& batch) {
  return std::vector<float>(static_cast<std::size_t>(batch.num_envs()) *
                            static_cast<std::size_t>(batch.action_dim()));
}

inline std::vector<float> act(Batch& batch, Policy policy) {
  std::vector<float> actions = zeros(batch);
  ScriptedPolicy(batch, policy).act(actions);
  return actions;
}

inline void step(Batch& batch, Policy policy) { batch.step(act(batch, policy)); }

}  // namespace engram::test
