// What a group's environments are asked for one by one or on demand, by their numbers in the group:
// queries, images, scripted policies, snapshots.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/batch/batch_group.h"
#include "core/batch/queries.h"
#include "core/batch/scene_renderer.h"
#include "core/batch/snapshot.h"

namespace engram {

class GroupQueries {
 public:
  // The group outlives this object.
  explicit GroupQueries(BatchGroup& group);

  // Calls of Queries, SceneRenderer and ScriptedPolicy for all environments.
  void robot_state(std::span<float> qpos, std::span<float> qvel, std::span<float> tcp_pose) const;
  void camera_params(std::string_view camera, int width, int height, const CameraSpans& out);
  std::string instruction(int env) const;
  // The batch of an environment, and its number there.
  std::pair<const Batch&, int> batch_of(int env) const;
  std::uint64_t unstable_count() const;
  void render(int env, std::string_view camera, int width, int height, std::span<std::uint8_t> rgb);
  void act(Policy policy, std::span<float> actions) const;

  // Sampled values of a single batch; 0 for several tasks, which draw different values.
  int sampled_dim() const;
  void sampled_values(std::span<float> values) const;

  // Snapshots. One environment is saved as its batch alone would save it. All environments of
  // several tasks fit a group of those tasks in their order.
  std::vector<std::byte> save(int env) const;
  std::vector<std::byte> save() const;
  std::size_t save_size(int env) const;
  std::size_t save_size() const;
  void restore(int env, std::span<const std::byte> bytes);
  void restore(std::span<const std::byte> bytes);

 private:
  struct Part {
    explicit Part(Batch& batch) : queries(batch), renderer(batch), snapshotter(batch) {}
    Queries queries;
    SceneRenderer renderer;
    Snapshotter snapshotter;
  };
  struct Place {
    const Part& part;
    int env;  // of the part
  };

  Place place_of(int env) const;

  BatchGroup& group_;
  std::deque<Part> parts_;
};

}  // namespace engram
