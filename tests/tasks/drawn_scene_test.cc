// Exported scenes of drawn episodes: in MuJoCo's own step everything stands still.
#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "core/batch/queries.h"
#include "core/scene/mujoco_handle.h"
#include "tests/env_helpers.h"

namespace engram::test {
namespace {

constexpr int kSteps = 200;  // two seconds

// Largest displacements of a run, m.
struct Displacements {
  double tcp = 0;
  double body = 0;
  std::string farthest;  // the body that moves so far
};

double distance(const double* a, const double* b) {
  return (Eigen::Map<const Eigen::Vector3d>(a) - Eigen::Map<const Eigen::Vector3d>(b)).norm();
}

class Stand {
 public:
  explicit Stand(const std::string& text) : model_(compile_model(text)), data_(make_data(*model_)) {
    mj_resetDataKeyframe(model_.get(), data_.get(), mj_name2id(model_.get(), mjOBJ_KEY, "start"));
    mj_forward(model_.get(), data_.get());
  }

  const mjModel& model() const { return *model_; }
  const mjData& data() const { return *data_; }

  Displacements run() {
    const MujocoScope scope;
    const int tcp = mj_name2id(model_.get(), mjOBJ_SITE, "tcp");
    const std::vector<double> sites(data_->site_xpos, data_->site_xpos + 3 * model_->nsite);
    const std::vector<double> bodies(data_->xpos, data_->xpos + 3 * model_->nbody);
    Displacements most;
    for (int i = 0; i < kSteps; ++i) {
      mj_step(model_.get(), data_.get());
      most.tcp = std::max(most.tcp, distance(data_->site_xpos + 3 * tcp, &sites[at(3 * tcp)]));
      for (int body = 1; body < model_->nbody; ++body) {
        const double moved = distance(data_->xpos + 3 * body, &bodies[at(3 * body)]);
        if (moved <= most.body) continue;
        most.body = moved;
        most.farthest = mj_id2name(model_.get(), mjOBJ_BODY, body);
      }
    }
    return most;
  }

  // Warnings of MuJoCo, a silent reset among them.
  int warnings() const {
    int count = 0;
    for (const mjWarningStat& warning : data_->warning) count += warning.number;
    return count;
  }

 private:
  ModelPtr model_;
  DataPtr data_;
};

void check_still(const std::string& id, std::uint64_t seed) {
  BatchOptions options;
  options.seed = seed;
  const auto batch = make_running(id, options);
  Stand stand(Queries(*batch).drawn_document(0));
  const Displacements most = stand.run();
  INFO(id << ", seed " << seed << ": " << most.farthest << " moves " << 1e3 * most.body
          << " mm, the TCP " << 1e3 * most.tcp << " mm");
  CHECK(most.tcp < 1e-4);
  CHECK(most.body < 1e-3);
  CHECK(stand.warnings() == 0);
}

}  // namespace

TEST_CASE("Exported scenes stand still in MuJoCo's own step", "[drawn_scene]") {
  for (const char* id : {"RememberColor3-VLA-v0", "ShellGamePick-VLA-v0", "InterceptSlow-VLA-v0",
                         "BatteriesCheckerEasy-3-VLA-v0", "FindImposterColor3-VLA-v0"}) {
    check_still(id, 0);
  }
}

TEST_CASE("All exported scenes stand still in MuJoCo's own step", "[drawn_scene][long]") {
  for (const std::string& id : implemented_ids()) {
    for (const std::uint64_t seed : {1, 2}) check_still(id, seed);
  }
}

TEST_CASE("Exported scenes have the drawn poses, and hidden props collide with nothing",
          "[drawn_scene]") {
  const auto batch = make_running("RememberColor9-VLA-v0");
  const State& state = batch->state();
  const Stand stand(Queries(*batch).drawn_document(0));
  int hidden = 0;
  for (int prop = 0; prop < state.num_props; ++prop) {
    const std::string& name = batch->physics_model().props()[at(prop)].name;
    const int body = mj_name2id(&stand.model(), mjOBJ_BODY, name.c_str());
    REQUIRE(body >= 0);
    const double* pos = stand.data().xpos + 3 * body;
    if (state.status_of(0, prop) == PropStatus::kHidden) {
      ++hidden;
      CHECK(pos[2] < -2);
    } else {
      CHECK(distance(pos, state.prop_pos_of(0, prop)) < 1e-12);
    }
    const int geom = stand.model().body_geomadr[body];
    const bool pairs =
        std::count(stand.model().pair_geom1, stand.model().pair_geom1 + stand.model().npair, geom) +
            std::count(stand.model().pair_geom2, stand.model().pair_geom2 + stand.model().npair,
                       geom) >
        0;
    CHECK(pairs == (state.status_of(0, prop) != PropStatus::kHidden));
  }
  CHECK(hidden == 8);
}

}  // namespace engram::test
