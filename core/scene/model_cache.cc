#include "core/scene/model_cache.h"

#include <map>
#include <string>

#include "core/threads/process_mutex.h"

namespace engram {
namespace {

using Models = std::map<std::string, std::weak_ptr<const PhysicsModel>>;

// Never destroyed: batches may outlive all static objects. Used under ProcessLock::kModels.
Models& models() {
  static Models* const all = new Models;
  return *all;
}

// Cache key of a scene: the text of the whole scene, and names and types of its props.
std::string key_of(const SceneSpec& source) {
  std::string key = source.compose_all();
  for (const std::string& prop : source.props) key += prop + '\n';
  return key;
}

// Deleter of cached models: removes the entry when the last user is gone, unless a newer model has
// replaced it.
struct EvictAndDelete {
  std::string key;
  void operator()(const PhysicsModel* model) const noexcept {
    {
      const std::lock_guard lock(process_mutex(ProcessLock::kModels));
      const auto found = models().find(key);
      if (found != models().end() && found->second.expired()) models().erase(found);
    }
    delete model;
  }
};

std::shared_ptr<const PhysicsModel> find(const std::string& key) {
  const std::lock_guard lock(process_mutex(ProcessLock::kModels));
  const auto found = models().find(key);
  return found == models().end() ? nullptr : found->second.lock();
}

}  // namespace

std::shared_ptr<const PhysicsModel> cached_model(const SceneSpec& source) {
  const std::string key = key_of(source);
  if (auto model = find(key)) return model;
  // Other threads may compile the same scene meanwhile: the first model to be finished is shared.
  auto compiled = std::make_unique<const PhysicsModel>(source);
  EvictAndDelete deleter{key};
  std::shared_ptr<const PhysicsModel> made(compiled.release(), std::move(deleter));
  const std::lock_guard lock(process_mutex(ProcessLock::kModels));
  std::weak_ptr<const PhysicsModel>& entry = models()[key];
  if (auto model = entry.lock()) return model;
  entry = made;
  return made;
}

}  // namespace engram
