#include "protocol/datasets/plan_document.h"

#include <limits>
#include <string>

#include "protocol/io/json_values.h"
#include "protocol/make/definitions.h"
#include "protocol/make/perturbations_document.h"
#include "protocol/make/physics_keys.h"
#include "protocol/make/variants.h"

namespace engram {
namespace {

// The ids of tasks.
std::vector<std::string> ids_of(std::span<const RegistryEntry* const> tasks) {
  std::vector<std::string> ids;
  for (const RegistryEntry* task : tasks) ids.emplace_back(task->id);
  return ids;
}

// Those that are variants of users, which are registered again where the document is read.
JsonList variants_among(std::span<const RegistryEntry* const> tasks) {
  JsonList all;
  for (const RegistryEntry* task : tasks) {
    if (task->constants != nullptr) all.push_back(to_document(variant_of(*task)));
  }
  return all;
}

CollectionPlan read(const Json& document) {
  constexpr auto kMax = static_cast<std::uint64_t>(std::numeric_limits<int>::max());
  CollectionPlan plan;
  plan.episodes = static_cast<int>(whole_number(part(document, "episodes"), kMax));
  plan.max_attempts = static_cast<int>(whole_number(part(document, "max_attempts"), kMax));
  plan.start_seed = whole_number(part(document, "start_seed"));
  plan.renderer = text(part(document, "renderer"));
  plan.rules = require_named<Rules>("rules", text(part(document, "rules")));
  const Json& mode = part(document, "control_mode");
  if (!is_null(mode)) {
    plan.control_mode = require_named<ControlMode>("control mode", text(mode));
  }
  plan.joint_proprio = truth(part(document, "joint_proprio"));
  plan.physics = require_named<Physics>("physics", text(part(document, kPhysicsKey)));
  plan.keep_failures = truth(part(document, "keep_failures"));
  plan.constants = table(part(document, "constants"));
  const Json& perturbations = part(document, "perturbations");
  if (!is_null(perturbations)) {
    for (const auto& [axis, level] : table(perturbations)) {
      plan.perturbations.push_back({require_axis(axis), number(level)});
    }
  }
  plan.additions = {truth(part(document, "labels")), truth(part(document, "depth")),
                    truth(part(document, "segmentation")), truth(part(document, "state")),
                    truth(part(document, "objects"))};
  return plan;
}

}  // namespace

Json plan_document(std::span<const RegistryEntry* const> tasks, const CollectionPlan& plan) {
  const std::vector<std::string> ids = ids_of(tasks);
  return JsonTable{{"version", version()},
                   {"tasks", to_list(ids)},
                   {"episodes", plan.episodes},
                   {"max_attempts", plan.max_attempts},
                   {"start_seed", plan.start_seed},
                   {"renderer", plan.renderer},
                   {"rules", name_of(plan.rules)},
                   {"control_mode", plan.control_mode ? Json(name_of(*plan.control_mode)) : Json()},
                   {"joint_proprio", plan.joint_proprio},
                   {kPhysicsKey, name_of(plan.physics)},
                   {kMujocoVersionKey, mujoco_version_of(plan.physics)},
                   {"keep_failures", plan.keep_failures},
                   {"constants", plan.constants},
                   {"perturbations", perturbations_document(plan.perturbations)},
                   {"labels", plan.additions.labels},
                   {"depth", plan.additions.depth},
                   {"segmentation", plan.additions.segmentation},
                   {"state", plan.additions.state},
                   {"objects", plan.additions.objects},
                   {"variants", variants_among(tasks)},
                   {"definitions", definitions_of(ids)}};
}

PlannedTasks planned_tasks(const Json& document, const std::filesystem::path& file) {
  const std::string shown = "'" + file.string() + "'";
  try {
    const std::string& of = text(part(document, "version"));
    if (of != version()) {
      throw Error(Error::kIo, "engram " + of + " wrote it, and this is engram " + version());
    }
    PlannedTasks planned{{}, read(document)};
    std::vector<TaskVariant> variants;
    for (const Json& variant : list(part(document, "variants"))) {
      variants.push_back(to_variant(variant, "variants"));
    }
    register_variants(variants);
    for (const Json& id : list(part(document, "tasks"))) {
      planned.tasks.push_back(&require_entry(text(id)));
    }
    require_definitions(ids_of(planned.tasks), part(document, "definitions"), shown);
    return planned;
  } catch (const Error& error) {
    if (error.kind() != Error::kIo) throw;
    throw Error(Error::kIo,
                shown + " is no collection that this engram goes on with (" + error.what() + ")");
  }
}

}  // namespace engram
