// What holds for every id of the Remember and Find-Imposter families.
#include "tasks/remember/object_recall.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <memory>
#include <string>

#include "core/scene/mujoco_handle.h"
#include "tasks/common/overlap_guard.h"
#include "tests/tasks/remember/recall_env.h"

namespace engram {
namespace {

using tasks::Layout, test::count_of, test::make_env, test::make_running, test::memory_int,
    test::Part, test::row, test::stored_pos;

TEST_CASE("State observations have the published lengths", "[object_recall]") {
  const std::map<int, int> lengths = {{3, 35}, {5, 41}, {6, 45}, {9, 53}, {15, 72}};
  for (const std::string& id : test::recall_ids()) {
    const auto batch = make_env(id);
    const bool nine = count_of(*batch) == 9 && id.find("ShapeAndColor") != std::string::npos;
    INFO(id);
    CHECK(batch->state_dim() == (nine ? 54 : lengths.at(count_of(*batch))));
  }
}

// The layouts of an episode by key: that of the cue where all objects have a place in it, and that
// of the manipulation phase.
Layout layout_of(const Batch& batch, const char* column, int width, int index) {
  const double* pos = row<double>(test::memory_of(batch).find(column), index);
  Layout layout;
  for (int key = 0; key < count_of(batch); ++key) {
    layout.push_back({pos[width * key], pos[width * key + 1]});
  }
  return layout;
}

double min_clearance(const tasks::ObjectSet& objects, const Layout& layout) {
  double least = 1;
  for (int i = 0; i < objects.count(); ++i) {
    for (int j = 0; j < i; ++j) {
      const tasks::Vec2 offset =
          layout[static_cast<std::size_t>(i)] - layout[static_cast<std::size_t>(j)];
      least = std::min(least, objects.clearance(j, i, offset));
    }
  }
  return least;
}

TEST_CASE("Objects keep 1 mm from each other in every layout", "[object_recall]") {
  for (const std::string& id : test::recall_ids(Part::kBrief)) {
    const BatchOptions options{.num_envs = 1000, .threads = 2};
    const auto batch = make_running(id, options);
    const tasks::ObjectSet objects = test::objects_of(*batch);
    const bool imposter = test::memory_of(*batch).find("cue_positions").field != nullptr;
    CHECK(imposter == (id.find("Imposter") != std::string::npos));
    double least = 1;
    for (int i = 0; i < options.num_envs; ++i) {
      least = std::min(least, min_clearance(objects, layout_of(*batch, "positions", 3, i)));
      if (!imposter) continue;
      least = std::min(least, min_clearance(objects, layout_of(*batch, "cue_positions", 2, i)));
    }
    INFO(id);
    CHECK(least >= tasks::kMinClearance);
  }
}

// The depth to which props are inside one another, according to MuJoCo, m.
double overlap(const mjModel& model, mjData& data, const Batch& batch, int index) {
  const State& state = batch.state();
  auto first_prop = static_cast<int>(model.nbody);
  for (int prop = 0; prop < state.num_props; ++prop) {
    const std::string& name = batch.physics_model().props()[static_cast<std::size_t>(prop)].name;
    const int body = mj_name2id(&model, mjOBJ_BODY, name.c_str());
    first_prop = std::min(first_prop, body);
    mjtNum* qpos = data.qpos + model.jnt_qposadr[model.body_jntadr[body]];
    std::copy_n(state.prop_pos_of(index, prop), 3, qpos);
    std::copy_n(state.prop_quat_of(index, prop), 4, qpos + 3);
  }
  mj_kinematics(&model, &data);
  mj_collision(&model, &data);
  double deepest = 0;
  for (int i = 0; i < data.ncon; ++i) {
    const mjContact& contact = data.contact[i];
    const int bodies[] = {model.geom_bodyid[contact.geom1], model.geom_bodyid[contact.geom2]};
    if (*std::min_element(bodies, bodies + 2) >= first_prop) {
      deepest = std::max(deepest, -contact.dist);
    }
  }
  return deepest;
}

TEST_CASE("No prop is inside another when all have appeared", "[object_recall]") {
  for (const std::string& id : test::recall_ids(Part::kBrief)) {
    const BatchOptions options{.num_envs = 40, .threads = 2};
    const auto batch = make_running(id, options);
    const ModelPtr model = compile_model(make_task(id)->document());
    const DataPtr data = make_data(*model);
    double deepest = 0;
    for (int t = 1; t <= 10; ++t) {
      test::step(*batch, Policy::kZero);
      for (int i = 0; i < options.num_envs; ++i) {
        if (t != test::appearance_of(*batch, i)) continue;
        deepest = std::max(deepest, overlap(*model, *data, *batch, i));
      }
    }
    INFO(id);
    CHECK(deepest == 0);
    // The test would see it.
    std::copy_n(batch->state().prop_pos_of(0, 0), 3, batch->state().prop_pos_of(0, 1));
    CHECK(overlap(*model, *data, *batch, 0) > 0.001);
  }
}

// Among fifteen objects the hand brushes a neighbour in one episode of a hundred.
TEST_CASE("Oracles leave alone what they do not mean to touch", "[object_recall][oracle]") {
  for (const std::string& id : test::recall_ids()) {
    BatchOptions options{.num_envs = 30, .threads = 2, .auto_reset = AutoReset::kOff};
    // As soon as can be.
    const std::unique_ptr<Task> task = make_task(id);
    for (const RandomVariable& draw : task->info().random_variables) {
      if (draw.name == "cue_steps" || draw.name == "empty_steps") {
        options.pins.push_back({draw.name, {draw.low}});
      }
    }
    const auto batch = make_running(id, options);
    const int steps = std::min(batch->info().horizon, test::appearance_of(*batch) + 30);
    for (int t = 0; t < steps; ++t) test::step(*batch, Policy::kOracle);
    int moved = 0;  // episodes
    for (int i = 0; i < options.num_envs; ++i) {
      bool any = false;
      for (int key = 0; key < count_of(*batch); ++key) {
        if (key == memory_int(*batch, "target", i)) continue;
        const Eigen::Vector3d away = test::object_pos(*batch, key, i) - stored_pos(*batch, key, i);
        any = any || away.norm() > 0.002;
      }
      moved += any ? 1 : 0;
    }
    INFO(id);
    CHECK(moved <= (count_of(*batch) == 15 ? 1 : 0));
  }
}

TEST_CASE("Episodes differ in nothing else if only what is hidden differs", "[object_recall]") {
  for (const std::string& id : test::recall_ids(Part::kBrief)) {
    BatchOptions options{.seed = 5};
    const auto play = [&](double hidden) {
      options.pins = {{make_task(id)->info().hidden_variable, {hidden}}};
      auto batch = make_running(id, options);
      const int appearance = test::appearance_of(*batch);
      for (int t = 0; t < appearance + 5; ++t) test::step(*batch, Policy::kZero);
      return batch;
    };
    const auto one = play(0);
    const auto other = play(2);
    INFO(id);
    CHECK(memory_int(*one, "target") != memory_int(*other, "target"));
    for (const char* column : {"qpos", "qvel", "prop_pos", "prop_quat", "prop_qvel", "prop_status",
                               "prop_slow_steps", "positions"}) {
      const ColumnView a = test::memory_of(*one).find(column);
      const ColumnView b = test::memory_of(*other).find(column);
      const std::size_t bytes = static_cast<std::size_t>(a.field->width) * size_of(a.field->dtype);
      INFO(column);
      CHECK(std::equal(a.row(0), a.row(0) + bytes, b.row(0)));
    }
  }
}

}  // namespace
}  // namespace engram
