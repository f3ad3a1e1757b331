// Contact constraints, islands and the cone solver against MuJoCo's own, in situations of episodes.
#include "core/contact/cone_solver.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "core/contact/coulomb_sliding.h"
#include "core/contact/islands.h"
#include "core/math/random.h"
#include "mjcf/battery.h"
#include "mjcf/mug.h"
#include "mjcf/object_shapes.h"
#include "tests/core/sim/physics_fixture.h"

namespace engram {
namespace {

using test::Rig;

// The largest differences from MuJoCo, in relation to the largest number of their kind.
struct Differences {
  double jacobian = 0;
  double reference = 0;
  double stiffness = 0;
  double acceleration = 0;
  double force = 0;
  long contacts = 0;
  long of_robot = 0;
  long islands = 0;
};

class Scale {
 public:
  void widen(double value) { most_ = std::max(most_, std::abs(value)); }
  void compare(double mine, double theirs) {
    widen(theirs);
    apart_ = std::max(apart_, std::abs(mine - theirs));
  }
  void raise(double& difference) const {
    if (apart_ > 0) difference = std::max(difference, apart_ / most_);
  }

 private:
  double most_ = 0;
  double apart_ = 0;
};

// A scene with all props awake, in which all contacts have so many dimensions.
class Probe {
 public:
  Probe(const SceneSpec& source, int condim)
      : scene_(compile(source, condim)),
        model_(*scene_.model),
        rows_({&scene_, 1}),
        islands_(rows_.max_bodies(), rows_.max_contacts()),
        solver_(kSize, rows_.max_contacts(), rows_.max_rows()),
        data_(make_data(model_)) {}

  // Props are in the order of the slots.
  void compare(const State& state, RandomStream& random, Differences& out) {
    load(state, random);
    solve_theirs();
    const int count = data_->nefc;
    if (count == 0) return;
    const std::vector<double> reference = copy(data_->efc_aref, count);
    const std::vector<double> stiffness = copy(data_->efc_D, count);
    const std::vector<double> force = copy(data_->efc_force, count);
    rows_.build(scene_, *data_, {});
    REQUIRE(data_->nefc == count);
    islands_.find(rows_, static_cast<int>(scene_.slots.size()) + 1);
    compare_rows(reference, stiffness, out);
    Scale acceleration;  // and of what the contacts take away
    for (int i = 0; i < model_.nv; ++i) acceleration.widen(data_->qacc_smooth[i]);
    for (int island = 0; island < islands_.count(); ++island) solve_mine(island, acceleration);
    acceleration.raise(out.acceleration);
    Scale forces;
    for (int i = 0; i < count; ++i) forces.compare(data_->efc_force[i], force[at(i)]);
    forces.raise(out.force);
    out.islands += islands_.count();
  }

 private:
  static constexpr int kSize = 100;
  static std::size_t at(int index) { return static_cast<std::size_t>(index); }
  static std::vector<double> copy(const mjtNum* from, int count) { return {from, from + count}; }

  static SceneModel compile(const SceneSpec& source, int condim) {
    std::vector<int> all(source.props.size());
    std::iota(all.begin(), all.end(), 0);
    SceneModel scene = compile_scene(source, all, RobotDetail::kCollision);
    std::fill_n(scene.model->pair_dim, scene.model->npair, condim);
    scene.model->opt.tolerance = 1e-15;
    return scene;
  }

  void load(const State& state, RandomStream& random) {
    std::copy_n(state.qpos.row(0), kRobotJoints, data_->qpos);
    std::copy_n(state.qvel.row(0), kRobotJoints, data_->qvel);
    for (int i = 0; i < model_.nv; ++i) data_->qacc_warmstart[i] = random.uniform(-1, 1);
    for (double& value : added_) value = random.uniform(0.1, 5);
    for (int i = 0; i < kRobotJoints; ++i) data_->qfrc_applied[i] = random.uniform(-20, 20);
    for (int prop = 0; prop < state.num_props; ++prop) {
      const PropSlot& slot = scene_.slots[at(prop)];
      std::copy_n(state.prop_pos_of(0, prop), 3, data_->qpos + slot.qpos);
      std::copy_n(state.prop_quat_of(0, prop), 4, data_->qpos + slot.qpos + 3);
      std::copy_n(state.prop_qvel_of(0, prop), 6, data_->qvel + slot.dof);
      data_->qfrc_applied[slot.dof + 2] = -9.81 * model_.body_mass[slot.body];
    }
  }

  // The robot's inertia gets a little on its diagonal, as if drives resisted.
  void solve_theirs() {
    mjData* d = data_.get();
    mj_kinematics(&model_, d);
    mj_comPos(&model_, d);
    mj_comVel(&model_, d);
    mj_crb(&model_, d);
    for (int i = 0; i < kRobotJoints; ++i) d->qM[model_.dof_Madr[i]] += added_[at(i)];
    mj_factorM(&model_, d);
    mj_collision(&model_, d);
    filter_contacts(model_, *d);
    mj_makeConstraint(&model_, d);
    mj_passive(&model_, d);
    mj_referenceConstraint(&model_, d);
    mj_rne(&model_, d, 0, d->qfrc_bias);
    mju_sub(d->qfrc_smooth, d->qfrc_passive, d->qfrc_bias, model_.nv);
    mju_addTo(d->qfrc_smooth, d->qfrc_applied, model_.nv);
    mj_solveM(&model_, d, d->qacc_smooth, d->qfrc_smooth, 1);
    start_ = copy(d->qacc_warmstart, model_.nv);
    if (d->nefc > 0) mj_fwdConstraint(&model_, d);
  }

  void compare_rows(const std::vector<double>& reference, const std::vector<double>& stiffness,
                    Differences& out) {
    Scale references;
    Scale stiffnesses;
    Scale jacobian;
    for (int i = 0; i < data_->nefc; ++i) {
      references.compare(data_->efc_aref[i], reference[at(i)]);
      stiffnesses.compare(data_->efc_D[i], stiffness[at(i)]);
    }
    for (const ContactConstraints::Contact& contact : rows_.contacts()) {
      ++out.contacts;
      out.of_robot += contact.bodies[0] == kRobotBody ? 1 : 0;
      for (int k = 0; k < contact.cone.dim; ++k) {
        const int row = contact.cone.row + k;
        for (int i = 0; i < model_.nv; ++i) {
          jacobian.compare(entry(contact, row, i), data_->efc_J[row * model_.nv + i]);
        }
      }
    }
    references.raise(out.reference);
    stiffnesses.raise(out.stiffness);
    jacobian.raise(out.jacobian);
  }

  // Entry of the Jacobian for one of MuJoCo's degrees of freedom.
  double entry(const ContactConstraints::Contact& contact, int row, int dof) const {
    const double* numbers = rows_.jacobian() + row * kRowWidth;
    for (std::size_t i = 0; i < 2; ++i) {
      const int body = contact.bodies[i];
      if (body == kNoBody) continue;
      const int first = body == kRobotBody ? 0 : scene_.slots[at(body - 1)].dof;
      const int count = body == kRobotBody ? kRobotJoints : kPropWidth;
      if (dof >= first && dof < first + count) return numbers[dof - first];
      numbers += contact.cone.width[i];
    }
    return 0;
  }

  void solve_mine(int island, Scale& accelerations) {
    std::vector<ConeBody> bodies;
    std::vector<double> masses(kSize * kSize);
    std::array<std::vector<double>, 3> vectors;
    vectors.fill(std::vector<double>(kSize));
    const mjtNum* const from[3] = {data_->qfrc_smooth, data_->qacc_smooth, start_.data()};
    double* mass = masses.data();
    std::vector<double> full(at(model_.nv * model_.nv));
    mj_fullM(&model_, full.data(), data_->qM);
    for (const int body : islands_.bodies(island)) {
      const bool robot = body == kRobotBody;
      const int width = robot ? kRobotWidth : kPropWidth;
      const int count = robot ? kRobotJoints : kPropWidth;
      const int dof = robot ? 0 : scene_.slots[at(body - 1)].dof;
      const int begin = islands_.begin_of(body);
      bodies.push_back({mass, begin, width});
      for (int i = 0; i < count; ++i) {
        for (std::size_t k = 0; k < 3; ++k) vectors[k][at(begin + i)] = from[k][dof + i];
        std::copy_n(&full[at((dof + i) * model_.nv + dof)], count, mass + i * width);
      }
      if (robot) mass[kRobotWidth * kRobotWidth - 1] = 1;
      mass += width * width;
    }
    solver_.solve(
        bodies, islands_.contacts(island),
        {rows_.jacobian(), data_->efc_D, data_->efc_aref, data_->efc_force},
        {model_.stat.meaninertia * model_.nv, model_.opt.tolerance, model_.opt.iterations},
        vectors[0].data(), vectors[1].data(), vectors[2].data());
    for (const int body : islands_.bodies(island)) {
      const bool robot = body == kRobotBody;
      const int dof = robot ? 0 : scene_.slots[at(body - 1)].dof;
      for (int i = 0; i < (robot ? kRobotJoints : kPropWidth); ++i) {
        accelerations.compare(solver_.acceleration()[islands_.begin_of(body) + i],
                              data_->qacc[dof + i]);
      }
    }
  }

  SceneModel scene_;
  const mjModel& model_;
  ContactConstraints rows_;
  Islands islands_;
  ConeSolver solver_;
  DataPtr data_;
  std::vector<double> start_;
  std::array<double, kRobotJoints> added_{};
};

// Compares after every control step of what `episode` does with a rig.
template <class Episode>
Differences compare_in(Rig& rig, int condim, const Episode& episode) {
  Probe probe(rig.task().scene(), condim);
  RandomStream random(1, 2, 3);
  Differences differences;
  rig.task().on_observe = [&](int) { probe.compare(rig.state(), random, differences); };
  episode(rig);
  rig.task().on_observe = [](int) {};
  return differences;
}

void check(const Differences& differences) {
  CHECK(differences.jacobian < 1e-12);
  CHECK(differences.reference < 1e-11);
  CHECK(differences.stiffness < 1e-12);
  CHECK(differences.acceleration < 1e-10);
  CHECK(differences.force < 1e-9);
}

constexpr double kClosed = tasks::kGripperClosed;
constexpr double kSqueeze = -1;

void lift_and_shake(Rig& rig, double height) {
  const Eigen::Vector3d place = rig.pos(0);
  const auto above = [&](double x, double y, double z) {
    return Eigen::Vector3d(place.x() + x, place.y() + y, z);
  };
  rig.move(above(0, 0, height + 0.08), 25);
  rig.move(above(0, 0, height), 15);
  rig.rest(6, kSqueeze);
  rig.move(above(0, 0, height + 0.1), 10, kSqueeze);
  rig.move(above(0.05, -0.05, height + 0.05), 10, kSqueeze);
  rig.move(above(0, 0, height), 10, kSqueeze);
}

void push_into(Rig& rig) {
  const Eigen::Vector3d place = rig.pos(0);
  rig.move(place + Eigen::Vector3d(-0.08, 0, 0.08), 25, kClosed);
  rig.move(place + Eigen::Vector3d(-0.08, 0, 0), 15, kClosed);
  rig.move(place + Eigen::Vector3d(0.12, 0, 0), 30, kClosed, 0.6F);
}

void press_on(Rig& rig) {
  const Eigen::Vector3d place = rig.pos(0);
  rig.move(place + Eigen::Vector3d(0, 0, 0.14), 25, kClosed);
  rig.move(place + Eigen::Vector3d(0, 0, 0.03), 20, kClosed);
}

TEST_CASE("A held cube is solved as MuJoCo does", "[physics][solver]") {
  Rig rig = Rig::cubes({{{-0.1, 0.1, 0.02}}});
  const Differences differences =
      compare_in(rig, GENERATE(1, 3, 4, 6), [](Rig& r) { lift_and_shake(r, 0.02); });
  check(differences);
  CHECK(differences.of_robot > 200);
}

TEST_CASE("A held battery is solved as MuJoCo does", "[physics][solver]") {
  Rig rig({mjcf::battery("battery")}, {{{-0.1, 0.1, 0.03}}});
  const Differences differences =
      compare_in(rig, GENERATE(3, 4), [](Rig& r) { lift_and_shake(r, 0.03); });
  check(differences);
  CHECK(differences.of_robot > 100);
}

TEST_CASE("A row of cubes that is pushed is solved as MuJoCo does", "[physics][solver]") {
  Rig rig = Rig::cubes({{{-0.1, 0.1, 0.02}}, {{-0.055, 0.105, 0.02}}, {{-0.055, 0.105, 0.0601}}});
  const Differences differences = compare_in(rig, GENERATE(1, 3, 4, 6), push_into);
  check(differences);
  CHECK(differences.of_robot > 20);
}

TEST_CASE("A stack that is pressed on is solved as MuJoCo does", "[physics][solver]") {
  Rig rig = Rig::cubes({{{-0.1, 0.1, 0.02}}, {{-0.1, 0.1, 0.0601}}, {{0.05, -0.1, 0.02}}});
  const Differences differences = compare_in(rig, GENERATE(3, 4, 6), press_on);
  check(differences);
  CHECK(differences.of_robot > 20);
}

TEST_CASE("Shapes that fall on one another are solved as MuJoCo does", "[physics][solver]") {
  std::vector<mjcf::Prop> props;
  std::vector<test::Placement> placements;
  for (int i = 0; i < 6; ++i) {
    const auto shape = static_cast<mjcf::ObjectShape>(i);
    props.push_back(mjcf::shape_prop("shape_" + std::to_string(i), shape, {0, 0, 1, 1}));
    placements.push_back({{-0.1 + 0.01 * i, 0.2, 0.05 + 0.05 * i}, PropStatus::kAwake});
  }
  Rig rig(std::move(props), std::move(placements));
  const Differences differences = compare_in(rig, GENERATE(1, 3, 4, 6), [](Rig& r) { r.rest(40); });
  check(differences);
  CHECK(differences.contacts > 500);
}

}  // namespace
}  // namespace engram
