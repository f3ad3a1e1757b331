// What tests of the Remember and Find-Imposter families share.
#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "tasks/remember/object_set.h"
#include "tests/env_helpers.h"

namespace engram::test {

// Parts of the families' ids. kBrief: those that begin at once, short VLA tasks and RL tasks.
enum class Part { kShort, kLong, kVla, kRl, kBrief, kAll };

inline bool is_in(const RegistryEntry& entry, Part part) {
  const bool rl = entry.split == Split::kRl;
  const bool lengthy = entry.id.find("Long") != std::string_view::npos;
  switch (part) {
    case Part::kShort:
      return !lengthy && !rl;
    case Part::kLong:
      return lengthy;
    case Part::kVla:
      return !rl;
    case Part::kRl:
      return rl;
    case Part::kBrief:
      return !lengthy;
    case Part::kAll:
      break;
  }
  return true;
}

// The ids of all families whose names begin like that.
inline std::vector<std::string> ids_of(std::string_view prefix, Part part = Part::kAll) {
  std::vector<std::string> ids;
  for (const RegistryEntry& entry : registry()) {
    if (entry.id.starts_with(prefix) && is_in(entry, part)) ids.emplace_back(entry.id);
  }
  return ids;
}

inline std::vector<std::string> recall_ids(Part part = Part::kAll) {
  std::vector<std::string> ids = ids_of("Remember", part);
  for (std::string& id : ids_of("FindImposter", part)) ids.push_back(std::move(id));
  return ids;
}

inline int count_of(const Batch& batch) { return batch.info().candidates; }

inline int memory_int(const Batch& batch, const char* name, int index = 0) {
  return *row<std::int32_t>(memory_of(batch).find(name), index);
}

inline int appearance_of(const Batch& batch, int index = 0) {
  return memory_int(batch, "cue_steps", index) + memory_int(batch, "empty_steps", index);
}

inline Eigen::Vector3d object_pos(const Batch& batch, int key, int index = 0) {
  return Eigen::Map<Eigen::Vector3d>(batch.state().prop_pos_of(index, key));
}

// Where an object rests in the manipulation phase.
inline Eigen::Vector3d stored_pos(const Batch& batch, int key, int index = 0) {
  return Eigen::Map<const Eigen::Vector3d>(row<double>(memory_of(batch).find("positions"), index) +
                                           3 * key);
}

inline tasks::Vocabulary vocabulary_of(std::string_view id) {
  if (id.find("ShapeAndColor") != std::string_view::npos) return tasks::Vocabulary::kShapeAndColor;
  return id.find("Shape") != std::string_view::npos ? tasks::Vocabulary::kShape
                                                    : tasks::Vocabulary::kColor;
}

inline tasks::ObjectSet objects_of(const Batch& batch) {
  return tasks::ObjectSet({vocabulary_of(batch.info().id), count_of(batch)});
}

inline bool is_visible(const Batch& batch, int key, int index = 0) {
  return batch.state().status_of(index, key) != PropStatus::kHidden;
}

// Success, info and state observation contain the target's present place and no other.
inline void check_outputs(const Batch& batch, const tasks::ObjectSet& objects) {
  const int target = memory_int(batch, "target");
  const Eigen::Vector3d pos = object_pos(batch, target);
  const float* offset = row<float>(batch.output("obj_to_goal_pos"), 0);
  for (int i = 0; i < 3; ++i) CHECK(offset[i] == Approx(pos[i] - batch.state().tcp_pos.row(0)[i]));

  const float* seen = batch.outputs().observation.data() + 25;
  const std::int32_t* oracle_info = row<std::int32_t>(batch.output("oracle_info"), 0);
  for (const int part : objects.identity(target)) {
    CHECK(*seen++ == static_cast<float>(part));
    CHECK(*oracle_info++ == part);
  }
  for (int key = 0; key < objects.count(); ++key) {
    for (int i = 0; i < 3; ++i) {
      CHECK(*seen++ == (key == target ? static_cast<float>(pos[i]) : 0.0F));
    }
  }
  CHECK(seen == batch.outputs().observation.data() + batch.outputs().observation.size());
}

// Counts that should be uniform over low..high: all values occur, none too often or too seldom.
inline void check_uniform(const std::map<int, int>& counts, int low, int high) {
  CHECK(counts.begin()->first == low);
  CHECK(counts.rbegin()->first == high);
  double total = 0;
  for (const auto& [value, count] : counts) total += count;
  const double expected = total / (high - low + 1);
  double chi_squared = 0;
  for (int value = low; value <= high; ++value) {
    const auto found = counts.find(value);
    const double count = found == counts.end() ? 0 : found->second;
    chi_squared += (count - expected) * (count - expected) / expected;
  }
  const double freedom = high - low;
  CHECK(chi_squared < freedom + 5 * std::sqrt(2 * freedom) + 1);
}

}  // namespace engram::test
