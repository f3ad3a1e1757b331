// Broad phase of collision detection: bounding-sphere tests of body pairs. Only pairs that may
// touch are left to MuJoCo, which tests explicit contact pairs geom by geom; scenes have thousands
// of them, and few are near.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <vector>

namespace engram {

class BroadPhase {
 public:
  // `model` must outlive this object. Only its explicit pairs collide.
  explicit BroadPhase(const mjModel& model);
  BroadPhase(BroadPhase&&) = default;
  BroadPhase& operator=(BroadPhase&&) = default;
  BroadPhase(const BroadPhase&) = delete;
  BroadPhase& operator=(const BroadPhase&) = delete;
  ~BroadPhase() = default;

  // Returns the model with fewer pairs: mj_collision finds the same contacts with it, in the same
  // order. Bodies and geoms must be posed in `data`. Valid until the next call.
  const mjModel* near_pairs(const mjData& data);

 private:
  // A plane, or the bounding sphere of a body's other geoms.
  struct Proxy {
    int plane = -1;          // geom, or -1
    int body = 0;            // of the sphere
    Eigen::Vector3d center;  // of the sphere, body frame
    double radius = 0;
  };
  // Consecutive pairs between the same two proxies.
  struct PairGroup {
    int first_proxy = 0;
    int second_proxy = 0;
    int begin = 0;
    int count = 0;
    double margin = 0;
  };

  int proxy_of(const mjModel& model, int geom);
  void add_pair(const mjModel& model, int pair);
  bool may_touch(const PairGroup& group, const mjData& data) const;
  void append_pairs(const PairGroup& group);

  const mjModel* model_;
  std::vector<Proxy> proxies_;
  std::vector<PairGroup> groups_;
  std::vector<Eigen::Vector3d> centers_;  // of the proxies' spheres, world

  // Shallow copy of the model with pair arrays of its own.
  mjModel filtered_model_;
  std::vector<int> dim_, geom1_, geom2_, signature_;
  std::vector<mjtNum> solref_, solimp_, margin_, gap_, friction_;
};

}  // namespace engram
