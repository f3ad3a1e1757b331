#include "protocol/make/physics_keys.h"

#include "core/scene/mujoco_handle.h"

namespace engram {

Json physics_in(const Json& document) {
  const Json* found = find(document, kPhysicsKey);
  return found == nullptr ? Json(name_of(Physics::kEngram)) : *found;
}

Json mujoco_version_of(Physics physics) {
  return physics == Physics::kMujoco ? Json(mj_versionString()) : Json();
}

std::string physics_text(const Json& document) {
  const Json* version = find(document, kMujocoVersionKey);
  const std::string name = text(physics_in(document));
  return version == nullptr ? name : name + " " + text(*version);
}

}  // namespace engram
