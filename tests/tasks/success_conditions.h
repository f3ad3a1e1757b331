// When the spec counts an episode as solved, worked out from what a spectator sees: poses, contacts
// and speeds, not from what tasks remember of them.
#pragma once

#include <array>
#include <memory>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "tests/tasks/spectator.h"

namespace engram::test {

// The control steps from which on something is so, for episodes whose lengths are pinned.
struct Timing {
  int cue_end = 0;
  int begin = 0;  // of the phase in which the robot is meant to act
};

class Judge {
 public:
  virtual ~Judge() = default;
  // To be called at reset and after every step: whether the conditions of success hold.
  virtual bool holds(const Spectator& scene) = 0;
  // False: more is needed for success than is looked at here.
  virtual bool exact() const { return true; }
};

// --- buttons ---

inline bool pressed(const Spectator& scene, std::string_view cap, double radius) {
  return horizontal(scene.tcp(), scene.pos(cap)) < radius && scene.tcp().z() <= 0.0831;
}

// A press counts once, and again only after a release.
class PressEvents {
 public:
  bool update(const Spectator& scene, std::string_view cap, double radius, bool action) {
    const bool inside = horizontal(scene.tcp(), scene.pos(cap)) < radius;
    if (action && (!inside || scene.tcp().z() >= 0.0852)) ready_ = true;
    const bool event = action && ready_ && pressed(scene, cap, radius);
    if (event) ready_ = false;
    return event;
  }

 private:
  bool ready_ = true;
};

// A press that is complete once the hand has been lifted.
class LiftedPresses {
 public:
  int begun = 0;
  int complete = 0;

  void update(const Spectator& scene, std::string_view cap, double radius, bool action, bool open) {
    const double height = scene.tcp().z();
    const bool inside = horizontal(scene.tcp(), scene.pos(cap)) < radius;
    if (action && (!inside || height >= 0.0852)) ready_ = true;
    if (action && open && ready_ && !pending_ && inside && height <= 0.0831) {
      ++begun;
      pending_ = true;
      ready_ = false;
      start_ = height;
    }
    if (action && open && ready_ && pending_ && height >= start_ + 0.085) {
      ++complete;
      pending_ = false;
    }
  }

 private:
  bool ready_ = true;
  bool pending_ = false;
  double start_ = 0;
};

// --- remember, find-imposter ---

// The tool is at the right object, and stands still if it has to, once objects may be touched.
class TouchedObject : public Judge {
 public:
  TouchedObject(Timing timing, bool still) : timing_(timing), still_(still) {}
  bool holds(const Spectator& scene) override {
    const bool two = scene.width("oracle_info") == 2;  // shape, colour
    const int key = two ? 3 * scene.info_int("oracle_info", 0) + scene.info_int("oracle_info", 1)
                        : scene.info_int("oracle_info");
    return (scene.pos(key) - scene.tcp()).norm() <= 0.05 && (scene.still() || !still_) &&
           scene.elapsed() >= timing_.begin;
  }

 private:
  Timing timing_;
  bool still_;
};

// --- shell games ---

constexpr std::array kMugs = {"mug_left", "mug_center", "mug_right"};

// The mug that stands in a slot: slots are in the order of y.
inline int mug_in_slot(const Spectator& scene, int slot) {
  std::vector<int> mugs = scene.props("mug_");
  std::sort(mugs.begin(), mugs.end(),
            [&](int a, int b) { return scene.pos(a).y() < scene.pos(b).y(); });
  return mugs[static_cast<std::size_t>(slot)];
}

// The tool stands still at the right mug, and no mug was shoved farther than that.
class TouchedMug : public Judge {
 public:
  explicit TouchedMug(Timing timing, double farthest = 0.05)
      : timing_(timing), farthest_(farthest) {}
  bool holds(const Spectator& scene) override {
    if (scene.elapsed() < timing_.begin) return false;
    double displacement = 0;
    for (std::size_t i = 0; i < kMugs.size(); ++i) {
      if (scene.elapsed() == timing_.begin) {
        start_[i] = scene.pos(kMugs[i]);
        slot_mug_ = mug_in_slot(scene, scene.info_int("oracle_info"));
      }
      displacement = std::max(displacement, horizontal(scene.pos(kMugs[i]), start_[i]));
    }
    return (scene.pos(slot_mug_) - scene.tcp()).norm() <= 0.08 && scene.still() &&
           displacement <= farthest_;
  }

 private:
  Timing timing_;
  double farthest_;  // m
  std::array<Point, 3> start_;
  int slot_mug_ = 0;
};

// The ball has been brought to its goal, a fixed way from where it lay, and the robot is slow.
class MovedBall : public Judge {
 public:
  MovedBall(Timing timing, const Point& way, double reach, double slowness)
      : timing_(timing), way_(way), reach_(reach), slowness_(slowness) {}
  bool holds(const Spectator& scene) override {
    if (scene.elapsed() == 0) goal_ = scene.pos("red_ball") + way_;
    return (goal_ - scene.pos("red_ball")).norm() <= reach_ && scene.still(slowness_) &&
           scene.elapsed() >= timing_.begin;
  }

 private:
  Timing timing_;
  Point way_;
  double reach_;
  double slowness_;
  Point goal_;
};

// The mug over the ball has been brought to the goal, and the robot is slow; not in the first step
// with mugs.
class MovedMug : public Judge {
 public:
  explicit MovedMug(Timing timing) : timing_(timing) {}
  bool holds(const Spectator& scene) override {
    const Point mug = scene.pos(scene.info_int("oracle_info"));
    return (scene.pos("goal_site") - mug).norm() <= 0.08 && scene.still() &&
           scene.elapsed() > timing_.begin;
  }

 private:
  Timing timing_;
};

// --- colours, blinks ---

// The right cubes, and no others, were touched within that of their touch points.
class TouchedColors : public Judge {
 public:
  TouchedColors(Timing timing, bool ordered, double radius)
      : timing_(timing), ordered_(ordered), radius_(radius) {}
  bool holds(const Spectator& scene) override { return touched_right(scene) && scene.still(); }

 protected:
  // Notes the touches of a step; whether those so far are the right ones.
  bool touched_right(const Spectator& scene) {
    if (scene.elapsed() < timing_.begin) return false;
    int near = -1;
    double nearest = radius_;
    for (const int cube : scene.props("cube_")) {
      const double distance = (scene.tcp() - scene.pos(cube) - Point(0, 0, 0.025)).norm();
      if (distance < nearest) {
        nearest = distance;
        near = cube;
      }
    }
    std::vector<int> wanted;
    for (int i = 0; i < scene.width("oracle_info"); ++i) {
      wanted.push_back(scene.info_int("oracle_info", i));
    }
    if (near >= 0 && scene.still() && touched_.insert(near).second) {
      if (order_.size() < wanted.size()) {
        order_.push_back(near);
      } else {
        order_.front() = near;
      }
    }
    return touched_ == std::set<int>(wanted.begin(), wanted.end()) &&
           (!ordered_ || order_ == wanted);
  }

  Timing timing_;

 private:
  bool ordered_;
  double radius_;  // m
  std::set<int> touched_;
  std::vector<int> order_;
};

// They were, and then the button was pressed, while no cube was far from where it appeared.
class TouchedColorsAndButton : public TouchedColors {
 public:
  using TouchedColors::TouchedColors;
  bool holds(const Spectator& scene) override {
    if (scene.elapsed() < timing_.begin) return false;
    double displacement = 0;
    for (const int cube : scene.props("cube_")) {
      if (scene.elapsed() == timing_.begin) start_.push_back(scene.pos(cube));
      displacement = std::max(displacement,
                              horizontal(scene.pos(cube), start_[static_cast<std::size_t>(cube)]));
    }
    const bool right = touched_right(scene) && displacement <= 0.06;
    presses_.update(scene, "center_button_cap", 0.065, true, right);
    return right && presses_.complete > 0 && scene.still();
  }

 private:
  std::vector<Point> start_;
  LiftedPresses presses_;
};

// As many presses as blinks, then the other button.
class CountedBlinks : public Judge {
 public:
  bool holds(const Spectator& scene) override {
    const bool action = scene.info("action_mask") != 0;
    const int blinks = scene.info_int("oracle_info");
    presses_.update(scene, "button_cap", 0.065, action, !failed_);
    const bool submit = submits_.update(scene, "confirm_button_cap", 0.065, action) && !submitted_;
    failed_ |= presses_.begun > blinks;
    if (submit && !failed_) solved_ = presses_.complete == blinks;
    failed_ |= submit && presses_.complete != blinks;
    submitted_ |= submit;
    return action && solved_;
  }

 private:
  LiftedPresses presses_;
  PressEvents submits_;
  bool submitted_ = false;
  bool failed_ = false;
  bool solved_ = false;
};

// --- balls, peg, cube ---

// The ball is in the goal.
class BallInGoal : public Judge {
 public:
  bool holds(const Spectator& scene) override {
    return horizontal(scene.pos("ball"), scene.pos("goal_region")) < 0.1;
  }
};

// Both fingers are pushed apart by it.
inline bool grasped(const Spectator& scene, int prop) {
  const Point apart = scene.tcp_rotation().col(1);
  for (const int finger : {0, 1}) {
    const Point force = scene.force(prop, finger);
    const Point opening = finger == 0 ? apart : -apart;
    const double cosine = force.normalized().dot(opening);
    if (force.norm() < 0.5 || cosine < std::cos(85 * std::numbers::pi / 180)) return false;
  }
  return true;
}

// The ball is held, and the robot stands still.
class BallGrasped : public Judge {
 public:
  bool holds(const Spectator& scene) override {
    return grasped(scene, scene.prop("ball")) && scene.still();
  }
};

// The peg has turned by the angle, if wanted in its place, and the robot stands still.
class PegTurned : public Judge {
 public:
  explicit PegTurned(bool in_place) : in_place_(in_place) {}
  bool holds(const Spectator& scene) override {
    const Eigen::Matrix3d rotation = scene.rotation("peg");
    const double yaw = std::atan2(-rotation(0, 1), rotation(0, 0));
    if (scene.elapsed() == 0) {
      start_yaw_ = yaw;
      start_ = scene.pos("peg");
    }
    const double error =
        std::remainder(scene.info("task_cue") - (yaw - start_yaw_), 2 * std::numbers::pi);
    const Point way = scene.pos("peg") - start_;
    const bool placed = !in_place_ || (std::abs(way.x()) < 0.05 && std::abs(way.y()) < 0.05);
    return std::abs(error) < 0.1 && scene.still() && placed;
  }

 private:
  bool in_place_;
  double start_yaw_ = 0;
  Point start_;
};

// The cube has been on the target and is back where it was.
class CubeReturned : public Judge {
 public:
  bool holds(const Spectator& scene) override {
    const Point cube = scene.pos("cube");
    if (scene.elapsed() == 0) {
      start_ = cube;
      goal_ = scene.pos("goal_region");
    }
    reached_ |= horizontal(cube, goal_) < 0.08;
    return reached_ && horizontal(cube, start_) < 0.08;
  }

 private:
  Point start_;
  Point goal_;
  bool reached_ = false;
};

// --- tracing, transfer, gathering, batteries ---

// The green cube has been led along the contours: the checkpoints are where the red cube has been.
class TracedContours : public Judge {
 public:
  explicit TracedContours(bool submitted) : submitted_(submitted) {}
  bool holds(const Spectator& scene) override {
    if (scene.info("demo_mask") != 0) path_.push_back(scene.pos("red_cube"));
    if (scene.info("action_mask") == 0) return false;
    const std::size_t shapes = path_.size() / 64;
    const Point cube = scene.pos("green_cube");
    for (std::size_t i = 0; i < 12 && closed_ < shapes; ++i) {
      if (horizontal(cube, checkpoint(closed_, i)) < 0.035) visited_.insert(i);
    }
    bool closes = false;
    if (closed_ < shapes && visited_.size() == 12) {
      closes = horizontal(cube, checkpoint(closed_, 0)) < 0.035;
    }
    if (!submitted_) return closes;
    if (closes) {
      ++closed_;
      visited_.clear();
    }
    if (presses_.update(scene, "trace_shape_seq_button_cap", 0.065, true)) {
      solved_ |= closed_ == shapes;
    }
    return solved_;
  }

 private:
  const Point& checkpoint(std::size_t shape, std::size_t index) const {
    return path_[64 * shape + 5 * index];
  }

  bool submitted_;
  std::vector<Point> path_;
  std::set<std::size_t> visited_;
  std::size_t closed_ = 0;
  PressEvents presses_;
  bool solved_ = false;
};

// The cube came onto the red disc in the window, not before.
class CubeInTime : public Judge {
 public:
  bool holds(const Spectator& scene) override {
    if (signal_ < 0 && scene.info("signal_on") != 0) signal_ = scene.elapsed();
    if (signal_ < 0) return false;
    const double delay = scene.info("oracle_info");
    const int first = signal_ + static_cast<int>(delay * 0.95);
    const int last = signal_ + static_cast<int>(delay * 1.05);
    const Point cube = scene.pos("blue_cube");
    const bool on_red = horizontal(cube, scene.pos("red_disc")) < 0.05 && cube.z() < 0.066;
    early_ |= on_red && scene.elapsed() < first;
    solved_ |= on_red && !early_ && scene.elapsed() >= first && scene.elapsed() <= last;
    return solved_;
  }

 private:
  int signal_ = -1;
  bool early_ = false;
  bool solved_ = false;
};

// All cubes lie on the disc, and the button of the flash was pressed.
class GatheredAndRecalled : public Judge {
 public:
  bool holds(const Spectator& scene) override {
    bool all = true;
    for (const int cube : scene.props("gather_cube_")) {
      all = all && horizontal(scene.pos(cube), scene.pos("target_disc")) < 0.10 &&
            scene.pos(cube).z() < 0.5 && scene.speed(cube) < 0.15;
    }
    constexpr std::array kCaps = {"button_red_cap", "button_green_cap", "button_blue_cap"};
    for (int k = 0; k < 3 && all && button_ < 0; ++k) {
      if (pressed(scene, kCaps[static_cast<std::size_t>(k)], 0.04)) button_ = k;
    }
    return all && button_ >= 0 && button_ == scene.info_int("oracle_info");
  }

 private:
  int button_ = -1;
};

// Every battery that works has been in the socket, and as many presses as there are of them were
// made. Which press confirmed which battery is not looked at.
class BatteriesFound : public Judge {
 public:
  bool exact() const override { return false; }
  bool holds(const Spectator& scene) override {
    const std::vector<int> batteries = active(scene);
    const float* poses = scene.observed("battery_pose");
    const Point socket = scene.pos("battery_socket_box");
    for (std::size_t i = 0; i < batteries.size(); ++i) {
      // Where it was before the task put it anywhere in this step.
      const Point seen = Eigen::Map<const Eigen::Vector3f>(poses + 7 * i).cast<double>();
      if (horizontal(seen, socket) <= 0.0101 && std::abs(seen.z() - 0.030) <= 0.0251) {
        inserted_.insert(i);
      }
    }
    if (presses_.update(scene, "battery_button_cap", 0.075, true)) ++count_;
    const int working = scene.width("oracle_info");
    bool all_tested = true;
    for (int i = 0; i < working; ++i) {
      const auto slot = static_cast<std::size_t>(scene.info_int("oracle_info", i));
      all_tested = all_tested && inserted_.contains(slot);
    }
    return all_tested && count_ >= working;
  }

 private:
  static std::vector<int> active(const Spectator& scene) {
    std::vector<int> all;
    for (int prop = 0; prop < scene.num_props(); ++prop) {
      const std::string& name = scene.prop_name(prop);
      if (name.starts_with("battery_") && std::isdigit(name[8]) != 0) all.push_back(prop);
    }
    return all;
  }

  std::set<std::size_t> inserted_;
  PressEvents presses_;
  int count_ = 0;
};

// The judge of a family's RL tasks, where they have other conditions; nullptr otherwise.
inline std::unique_ptr<Judge> make_rl_judge(std::string_view family, Timing timing) {
  if (family == "ChainOfColors") return std::make_unique<TouchedColors>(timing, true, 0.02);
  if (family.ends_with("OfColors")) return std::make_unique<TouchedColors>(timing, false, 0.02);
  if (family == "ShellGameTouch") return std::make_unique<TouchedMug>(timing, 1e3);
  if (family.starts_with("ShellGame")) return std::make_unique<MovedMug>(timing);
  return nullptr;
}

// The judge of a family of the benchmark; nullptr for others.
inline std::unique_ptr<Judge> make_judge(std::string_view family, Timing timing, bool rl = false) {
  if (rl) {
    if (auto judge = make_rl_judge(family, timing)) return judge;
  }
  const auto is = [family](std::string_view prefix) { return family.starts_with(prefix); };
  if (is("Remember")) return std::make_unique<TouchedObject>(timing, true);
  if (is("FindImposter")) return std::make_unique<TouchedObject>(timing, false);
  if (is("ShellGamePush")) {
    return std::make_unique<MovedBall>(timing, Point(0.1, 0, 0.03), 0.06, 0.3);
  }
  if (is("ShellGamePick")) {
    return std::make_unique<MovedBall>(timing, Point(0, 0, 0.125), 0.05, 0.2);
  }
  if (is("ShellGame")) return std::make_unique<TouchedMug>(timing);
  if (is("ChainOfColors")) return std::make_unique<TouchedColorsAndButton>(timing, true, 0.05);
  if (is("BunchOfColors") || is("SeqOfColors")) {
    return std::make_unique<TouchedColorsAndButton>(timing, false, 0.05);
  }
  if (is("BlinkCount")) return std::make_unique<CountedBlinks>();
  if (is("InterceptGrab")) return std::make_unique<BallGrasped>();
  if (is("Intercept")) return std::make_unique<BallInGoal>();
  if (is("Rotate")) return std::make_unique<PegTurned>(is("RotateStrict"));
  if (is("TakeItBack")) return std::make_unique<CubeReturned>();
  if (is("TraceShape")) return std::make_unique<TracedContours>(is("TraceShapeSeq"));
  if (is("TimedTransfer")) return std::make_unique<CubeInTime>();
  if (is("GatherAndRecall")) return std::make_unique<GatheredAndRecalled>();
  if (is("BatteriesChecker")) return std::make_unique<BatteriesFound>();
  return nullptr;
}

}  // namespace engram::test
