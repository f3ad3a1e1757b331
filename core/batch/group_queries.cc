#include "core/batch/group_queries.h"

#include <cstring>

#include "core/base/error.h"

namespace engram {
namespace {

// Precedes the snapshots of several tasks, each behind its length.
constexpr char kMagic[8] = {'e', 'n', 'g', 'r', 'a', 'm', 's', 'g'};

// Rows of one part in an array of all environments; empty arrays stay so.
template <class T>
std::span<T> rows_of(std::span<T> all, const BatchGroup& group, int part) {
  if (all.empty()) return all;
  const std::size_t width = all.size() / static_cast<std::size_t>(group.num_envs());
  return all.subspan(static_cast<std::size_t>(group.first_env(part)) * width,
                     static_cast<std::size_t>(group.part(part).num_envs()) * width);
}

void require_rows(const char* what, std::span<const float> all, const BatchGroup& group,
                  std::size_t width) {
  if (all.empty()) return;
  require_length(what, all.size(), static_cast<std::size_t>(group.num_envs()) * width);
}

void append(std::vector<std::byte>& bytes, std::uint64_t number) {
  const auto* const begin = reinterpret_cast<const std::byte*>(&number);
  bytes.insert(bytes.end(), begin, begin + sizeof number);
}

// The snapshots of `count` parts. Throws Error if the bytes are of something else.
std::vector<std::span<const std::byte>> split(std::span<const std::byte> bytes, int count) {
  const auto refuse = [](const std::string& why) {
    throw Error(Error::kInvalidArgument, "snapshot refused: " + why);
  };
  const auto number = [&] {
    std::uint64_t value = 0;
    if (bytes.size() < sizeof value) refuse("its end is missing");
    std::memcpy(&value, bytes.data(), sizeof value);
    bytes = bytes.subspan(sizeof value);
    return value;
  };
  if (bytes.size() < sizeof kMagic || std::memcmp(bytes.data(), kMagic, sizeof kMagic) != 0) {
    refuse("not of a group of tasks");
  }
  bytes = bytes.subspan(sizeof kMagic);
  const std::uint64_t given = number();
  if (given != static_cast<std::uint64_t>(count)) {
    refuse(std::to_string(given) + " tasks given, " + std::to_string(count) + " needed");
  }
  std::vector<std::span<const std::byte>> parts;
  for (int i = 0; i < count; ++i) {
    const std::uint64_t size = number();
    if (size > bytes.size()) refuse("its end is missing");
    parts.push_back(bytes.first(size));
    bytes = bytes.subspan(size);
  }
  if (!bytes.empty()) refuse(std::to_string(bytes.size()) + " bytes too many");
  return parts;
}

}  // namespace

GroupQueries::GroupQueries(BatchGroup& group) : group_(group) {
  for (int i = 0; i < group.num_parts(); ++i) parts_.emplace_back(group.part(i));
}

GroupQueries::Place GroupQueries::place_of(int env) const {
  const int part = group_.part_of(env);
  return {parts_[static_cast<std::size_t>(part)], env - group_.first_env(part)};
}

void GroupQueries::robot_state(std::span<float> qpos, std::span<float> qvel,
                               std::span<float> tcp_pose) const {
  require_rows("qpos", qpos, group_, kRobotJoints);
  require_rows("qvel", qvel, group_, kRobotJoints);
  require_rows("tcp_pose", tcp_pose, group_, 7);
  for (int i = 0; i < group_.num_parts(); ++i) {
    parts_[static_cast<std::size_t>(i)].queries.robot_state(
        rows_of(qpos, group_, i), rows_of(qvel, group_, i), rows_of(tcp_pose, group_, i));
  }
}

void GroupQueries::camera_params(std::string_view camera, int width, int height,
                                 const CameraSpans& out) {
  require_rows("extrinsic_cv", out.extrinsic_cv, group_, 12);
  require_rows("cam2world_gl", out.cam2world_gl, group_, 16);
  require_rows("intrinsic_cv", out.intrinsic_cv, group_, 9);
  for (int i = 0; i < group_.num_parts(); ++i) {
    parts_[static_cast<std::size_t>(i)].queries.camera_params(
        camera, width, height,
        {.extrinsic_cv = rows_of(out.extrinsic_cv, group_, i),
         .cam2world_gl = rows_of(out.cam2world_gl, group_, i),
         .intrinsic_cv = rows_of(out.intrinsic_cv, group_, i)});
  }
}

std::pair<const Batch&, int> GroupQueries::batch_of(int env) const {
  const int part = group_.part_of(env);
  return {group_.part(part), env - group_.first_env(part)};
}

std::string GroupQueries::instruction(int env) const {
  const Place place = place_of(env);
  return place.part.queries.instruction(place.env);
}

std::uint64_t GroupQueries::unstable_count() const {
  std::uint64_t count = 0;
  for (const Part& part : parts_) count += part.queries.unstable_count();
  return count;
}

void GroupQueries::render(int env, std::string_view camera, int width, int height,
                          std::span<std::uint8_t> rgb) {
  const int part = group_.part_of(env);
  parts_[static_cast<std::size_t>(part)].renderer.render(env - group_.first_env(part), camera,
                                                         width, height, rgb);
}

void GroupQueries::act(Policy policy, std::span<float> actions) const {
  group_.act(policy, actions);
}

int GroupQueries::sampled_dim() const {
  return group_.is_common() ? 0 : parts_.front().queries.sampled_dim();
}

void GroupQueries::sampled_values(std::span<float> values) const {
  if (group_.is_common()) {
    require_length("drawn values", values.size(), 0);
  } else {
    parts_.front().queries.sampled_values(values);
  }
}

// --- snapshots ---

std::vector<std::byte> GroupQueries::save(int env) const {
  const Place place = place_of(env);
  return place.part.snapshotter.save(place.env);
}

std::size_t GroupQueries::save_size(int env) const {
  const Place place = place_of(env);
  return place.part.snapshotter.save_size(place.env);
}

std::vector<std::byte> GroupQueries::save() const {
  if (!group_.is_common()) return parts_.front().snapshotter.save();
  std::vector<std::byte> bytes;
  const auto* const magic = reinterpret_cast<const std::byte*>(kMagic);
  bytes.insert(bytes.end(), magic, magic + sizeof kMagic);
  append(bytes, parts_.size());
  for (const Part& part : parts_) {
    const std::vector<std::byte> saved = part.snapshotter.save();
    append(bytes, saved.size());
    bytes.insert(bytes.end(), saved.begin(), saved.end());
  }
  return bytes;
}

std::size_t GroupQueries::save_size() const {
  if (!group_.is_common()) return parts_.front().snapshotter.save_size();
  std::size_t size = sizeof kMagic + sizeof(std::uint64_t);
  for (const Part& part : parts_) size += sizeof(std::uint64_t) + part.snapshotter.save_size();
  return size;
}

void GroupQueries::restore(int env, std::span<const std::byte> bytes) {
  const Place place = place_of(env);
  place.part.snapshotter.restore(place.env, bytes);
}

void GroupQueries::restore(std::span<const std::byte> bytes) {
  if (!group_.is_common()) {
    parts_.front().snapshotter.restore(bytes);
    return;
  }
  const std::vector<std::span<const std::byte>> saved = split(bytes, group_.num_parts());
  for (std::size_t i = 0; i < saved.size(); ++i) parts_[i].snapshotter.check(saved[i]);
  for (std::size_t i = 0; i < saved.size(); ++i) parts_[i].snapshotter.restore(saved[i]);
}

}  // namespace engram
