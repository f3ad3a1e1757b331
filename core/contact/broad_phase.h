// Leaves collision detection only the pairs of bodies that are near one another. MuJoCo goes
// through explicit contact pairs geom by geom; scenes have thousands of them, and few are near.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <vector>

namespace engram {

class BroadPhase {
 public:
  // `model` must outlive the sieve. Its explicit pairs are all that collides.
  explicit BroadPhase(const mjModel& model);
  BroadPhase(BroadPhase&&) = default;
  BroadPhase& operator=(BroadPhase&&) = default;
  BroadPhase(const BroadPhase&) = delete;
  BroadPhase& operator=(const BroadPhase&) = delete;
  ~BroadPhase() = default;

  // The model with fewer pairs: mj_collision finds the same contacts with it, in the same order.
  // Needs bodies and geoms posed in `data`. Valid until the next call.
  const mjModel* near_pairs(const mjData& data);

 private:
  // A plane, or a ball around the geoms of a body that take part in pairs.
  struct Member {
    int plane = -1;          // geom, or -1
    int body = 0;            // of the ball
    Eigen::Vector3d center;  // of the ball, body frame
    double radius = 0;
  };
  // Consecutive pairs between the same two members.
  struct Group {
    int first_member = 0;
    int second_member = 0;
    int begin = 0;
    int count = 0;
    double margin = 0;
  };

  int member_of(const mjModel& model, int geom);
  void add_pair(const mjModel& model, int pair);
  bool is_near(const Group& group, const mjData& data) const;
  void keep(const Group& group);

  const mjModel* model_;
  std::vector<Member> members_;
  std::vector<Group> groups_;
  std::vector<Eigen::Vector3d> centers_;  // of the members' balls, world

  // The thinned model: a shallow copy with pairs of its own.
  mjModel thinned_;
  std::vector<int> dim_, geom1_, geom2_, signature_;
  std::vector<mjtNum> solref_, solimp_, margin_, gap_, friction_;
};

}  // namespace engram
