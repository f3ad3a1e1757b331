// Depth and segmentation in observations.
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/batch/queries.h"
#include "core/batch/scripted_policy.h"
#include "core/batch/snapshot.h"
#include "protocol/make/make.h"
#include "tests/allocation_counter.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

constexpr const char* kId = "RememberColor9-VLA-v0";
constexpr int kSide = 128;
constexpr std::size_t kCells = std::size_t{kSide} * kSide * 2;
constexpr const char* kCameras[2] = {"base_camera", "hand_camera"};
constexpr double kTableTop = -0.0005;  // of the box that is seen
constexpr double kHalfCube = 0.02;

BatchOptions seeing(ObsMode mode, int num_envs, std::uint64_t seed = 11) {
  BatchOptions options{.num_envs = num_envs, .seed = seed, .threads = 1, .obs_mode = mode};
  return options;
}

using Cells = std::vector<std::int16_t>;

Cells cells_of(std::span<const std::int16_t> all, int env) {
  const auto row = all.subspan(kCells * static_cast<std::size_t>(env), kCells);
  return {row.begin(), row.end()};
}

// Depth and segmentation, one after the other.
Cells all_cells(const Batch& batch) {
  Cells cells(batch.images().depth.begin(), batch.images().depth.end());
  cells.insert(cells.end(), batch.images().segmentation.begin(), batch.images().segmentation.end());
  return cells;
}

int segment_named(const Batch& batch, const std::string& name) {
  const auto names = batch.images().segmentation_names;
  const auto found = std::find(names.begin(), names.end(), name);
  REQUIRE(found != names.end());
  return static_cast<int>(found - names.begin());
}

// One camera of one environment.
class Eye {
 public:
  Eye(Batch& batch, int index, int camera) : batch_(batch), index_(index), camera_(camera) {
    const auto count = static_cast<std::size_t>(batch.num_envs());
    std::vector<float> extrinsic(12 * count);
    std::vector<float> intrinsic(9 * count);
    Queries(batch).camera_params(
        kCameras[camera], kSide, kSide,
        {.extrinsic_cv = extrinsic, .cam2world_gl = {}, .intrinsic_cv = intrinsic});
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        pose_(row, column) =
            static_cast<double>(extrinsic[static_cast<std::size_t>(12 * index + 4 * row + column)]);
      }
    }
    focal_ = static_cast<double>(intrinsic[static_cast<std::size_t>(9 * index)]);
  }

  int depth(int x, int y) const { return batch_.images().depth[at(x, y)]; }
  int segment(int x, int y) const { return batch_.images().segmentation[at(x, y)]; }

  // Where the pixel's middle meets what it shows.
  Eigen::Vector3d point(int x, int y) const {
    const double z = depth(x, y) / 1000.0;
    const Eigen::Vector3d seen((x + 0.5 - kSide / 2.0) / focal_ * z,
                               (y + 0.5 - kSide / 2.0) / focal_ * z, z);
    return pose_.leftCols<3>().transpose() * (seen - pose_.col(3));
  }
  // Where a point of the world shows.
  Eigen::Vector2d project(const Eigen::Vector3d& point) const {
    const Eigen::Vector3d seen = pose_.leftCols<3>() * point + pose_.col(3);
    return {focal_ * seen.x() / seen.z() + kSide / 2.0, focal_ * seen.y() / seen.z() + kSide / 2.0};
  }

 private:
  std::size_t at(int x, int y) const {
    return kCells * static_cast<std::size_t>(index_) +
           static_cast<std::size_t>(2 * (kSide * y + x) + camera_);
  }

  Batch& batch_;
  int index_;
  int camera_;
  Eigen::Matrix<double, 3, 4> pose_;
  double focal_ = 0;
};

template <class Visit>
void for_pixels(Visit&& visit) {
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) visit(x, y);
  }
}

Eigen::Vector3d position_of(const Batch& batch, int index, int prop) {
  const double* pos = batch.state().prop_pos_of(index, prop);
  return {pos[0], pos[1], pos[2]};
}

Eigen::Quaterniond turn_of(const Batch& batch, int index, int prop) {
  const double* quat = batch.state().prop_quat_of(index, prop);
  return {quat[0], quat[1], quat[2], quat[3]};
}

}  // namespace

TEST_CASE("Modes with depth or segmentation have the colours of rgb", "[render][depth]") {
  const auto rgb = make(kId, seeing(ObsMode::kRgb, 2));
  const auto depth = make(kId, seeing(ObsMode::kRgbDepth, 2));
  const auto segmentation = make(kId, seeing(ObsMode::kRgbSegmentation, 2));
  const auto both = make(kId, seeing(ObsMode::kRgbDepthSegmentation, 2));
  const std::array<Batch*, 4> all = {rgb.get(), depth.get(), segmentation.get(), both.get()};
  for (Batch* batch : all) batch->reset();
  for (int t = 0; t < 8; ++t) {
    for (Batch* batch : all) {
      CHECK(std::ranges::equal(batch->images().rgb, rgb->images().rgb));
      CHECK(batch->outputs().observation.empty());
      CHECK(std::ranges::equal(batch->outputs().proprio, rgb->outputs().proprio));
    }
    REQUIRE(both->images().depth.size() == 2 * kCells);
    REQUIRE(both->images().segmentation.size() == 2 * kCells);
    CHECK(std::ranges::equal(depth->images().depth, both->images().depth));
    CHECK(std::ranges::equal(segmentation->images().segmentation, both->images().segmentation));
    const std::vector<float> actions = test::act(*rgb, Policy::kOracle);
    for (Batch* batch : all) batch->step(actions);
  }
  CHECK(rgb->images().depth.empty());
  CHECK(rgb->images().segmentation.empty());
  CHECK(rgb->images().segmentation_names.empty());
  CHECK(depth->images().segmentation.empty());
  CHECK(depth->images().segmentation_names.empty());
  CHECK(segmentation->images().depth.empty());
  CHECK(segmentation->images().segmentation_names.size() ==
        both->images().segmentation_names.size());
  CHECK(Queries(*rgb).bytes_per_env() + sizeof(std::int16_t) * 2 * kCells ==
        Queries(*both).bytes_per_env());
}

TEST_CASE("Depth is the distance along the axis to what is there", "[render][depth]") {
  const auto batch = make(kId, seeing(ObsMode::kRgbDepthSegmentation, 2));
  batch->reset();
  for (int t = 0; t < 30; ++t) test::step(*batch, Policy::kOracle);
  const int table = segment_named(*batch, "table");
  std::map<int, int> prop_of;
  const std::vector<PropModel>& props = batch->physics_model().props();
  for (std::size_t i = 0; i < props.size(); ++i) {
    if (props[i].name.starts_with("cube")) {
      prop_of[segment_named(*batch, props[i].name)] = static_cast<int>(i);
    }
  }
  REQUIRE(prop_of.size() == 9);
  int on_table = 0;
  int on_cubes = 0;
  double worst_table = 0;
  double worst_cube = 0;
  for (int index = 0; index < 2; ++index) {
    for (int camera = 0; camera < 2; ++camera) {
      const Eye eye(*batch, index, camera);
      for_pixels([&](int x, int y) {
        const int segment = eye.segment(x, y);
        CHECK((eye.depth(x, y) == 0) == (segment == 0));
        const Eigen::Vector3d point = eye.point(x, y);
        if (segment == table && point.z() > -0.1) {  // not its front
          ++on_table;
          worst_table = std::max(worst_table, std::abs(point.z() - kTableTop));
        }
        const auto found = prop_of.find(segment);
        if (found == prop_of.end()) return;
        ++on_cubes;
        const Eigen::Vector3d local = turn_of(*batch, index, found->second).conjugate() *
                                      (point - position_of(*batch, index, found->second));
        worst_cube = std::max(worst_cube, std::abs(local.cwiseAbs().maxCoeff() - kHalfCube));
      });
    }
  }
  CHECK(on_table > 10000);
  CHECK(on_cubes > 500);
  CHECK(worst_table < 0.0007);
  CHECK(worst_cube < 0.001);
}

TEST_CASE("Each segment is where its prop is, and has the name of the prop", "[render][depth]") {
  const auto batch = make(kId, seeing(ObsMode::kRgbSegmentation, 4));
  batch->reset();
  while (batch->state().elapsed[0] < 16) test::step(*batch, Policy::kZero);
  const std::vector<PropModel>& props = batch->physics_model().props();
  int seen = 0;
  for (int index = 0; index < 4; ++index) {
    const Eye eye(*batch, index, 0);
    for (std::size_t i = 0; i < props.size(); ++i) {
      if (!props[i].name.starts_with("cube")) continue;
      const int prop = static_cast<int>(i);
      if (batch->state().status_of(index, prop) == PropStatus::kHidden) continue;
      const int segment = segment_named(*batch, props[i].name);
      const Eigen::Vector2d middle = eye.project(position_of(*batch, index, prop));
      INFO(props[i].name << " of environment " << index);
      CHECK(eye.segment(static_cast<int>(middle.x()), static_cast<int>(middle.y())) == segment);
      double farthest = 0;
      for_pixels([&](int x, int y) {
        if (eye.segment(x, y) == segment) {
          farthest = std::max(farthest, (Eigen::Vector2d(x + 0.5, y + 0.5) - middle).norm());
        }
      });
      CHECK(farthest < 12);
      ++seen;
    }
  }
  CHECK(seen >= 27);
}

TEST_CASE("Segments are named in the scene's order, the same in all episodes", "[render][depth]") {
  const auto batch = make(kId, seeing(ObsMode::kRgbSegmentation, 1));
  const std::vector<std::string> names(batch->images().segmentation_names.begin(),
                                       batch->images().segmentation_names.end());
  REQUIRE(names.size() > 12);
  CHECK(names[0] == "background");
  CHECK(names[1] == "table");
  CHECK(names[2] == "ground");
  CHECK(names[3] == "link0");
  CHECK(std::set<std::string>(names.begin(), names.end()).size() == names.size());
  const auto other = make(kId, seeing(ObsMode::kRgbDepthSegmentation, 2, 99));
  CHECK(std::ranges::equal(names, other->images().segmentation_names));
}

TEST_CASE("Values of segmentation are those that have names, in all tasks", "[render][depth]") {
  for (const std::string& id : test::implemented_ids()) {
    const auto batch = make(id, seeing(ObsMode::kRgbDepthSegmentation, 1, 3));
    batch->reset();
    const auto names = batch->images().segmentation_names;
    const std::vector<PropModel>& props = batch->physics_model().props();
    std::set<std::string> known(names.begin(), names.end());
    INFO(id);
    CHECK(known.size() == names.size());
    CHECK(!known.contains(""));
    for (const std::int16_t value : batch->images().segmentation) {
      REQUIRE(value >= 0);
      REQUIRE(static_cast<std::size_t>(value) < names.size());
    }
    const auto named = std::count_if(props.begin(), props.end(), [&](const PropModel& prop) {
      return known.contains(prop.name);
    });
    CHECK(named > 0);
    CHECK(std::ranges::count(batch->images().segmentation, segment_named(*batch, "table")) > 2000);
  }
}

TEST_CASE("Depth and segmentation are the same for any threads, chunks, batch size and slot",
          "[render][depth]") {
  const auto run = [](BatchOptions options) {
    const auto batch = make(kId, options);
    batch->reset();
    Cells cells = all_cells(*batch);
    for (int t = 0; t < 10; ++t) {
      test::step(*batch, Policy::kOracle);
      const Cells now = all_cells(*batch);
      cells.insert(cells.end(), now.begin(), now.end());
    }
    return cells;
  };
  const BatchOptions one = seeing(ObsMode::kRgbDepthSegmentation, 5);
  BatchOptions three = one;
  three.threads = 3;
  three.chunk = 2;
  CHECK(run(one) == run(three));

  const auto batch = make(kId, one);
  const auto single = make(kId, seeing(ObsMode::kRgbDepthSegmentation, 1, 11 + 3));
  batch->reset();
  single->reset();
  for (int t = 0; t < 10; ++t) {
    CHECK(cells_of(batch->images().depth, 3) == cells_of(single->images().depth, 0));
    CHECK(cells_of(batch->images().segmentation, 3) == cells_of(single->images().segmentation, 0));
    test::step(*batch, Policy::kOracle);
    test::step(*single, Policy::kOracle);
  }
}

TEST_CASE("Depth and segmentation follow resets, ends and snapshots as colours do",
          "[render][depth]") {
  BatchOptions same = seeing(ObsMode::kRgbDepthSegmentation, 1);
  same.auto_reset = AutoReset::kSameStep;
  BatchOptions off = same;
  off.auto_reset = AutoReset::kOff;
  const auto batch = make(kId, same);
  const auto twin = make(kId, off);
  batch->reset();
  twin->reset();
  std::vector<std::byte> snapshot;
  Cells then;
  for (int t = 0; t < batch->info().horizon; ++t) {
    if (t == 20) {
      snapshot = Snapshotter(*twin).save();
      then = all_cells(*twin);
    }
    test::step(*batch, Policy::kOracle);
    test::step(*twin, Policy::kOracle);
  }
  REQUIRE(batch->outputs().final_mask[0] == 1);
  CHECK(std::ranges::equal(test::final_images(*batch).depth, twin->images().depth));
  CHECK(std::ranges::equal(test::final_images(*batch).segmentation, twin->images().segmentation));
  CHECK(test::final_images(*twin).depth.empty());
  CHECK(all_cells(*batch) != all_cells(*twin));
  Snapshotter(*twin).restore(snapshot);
  CHECK(all_cells(*twin) == then);
}

TEST_CASE("Steps that draw depth and segmentation do not allocate", "[render][depth][allocation]") {
  BatchOptions options = seeing(ObsMode::kRgbDepthSegmentation, 4);
  options.threads = GENERATE(1, 2);
  options.auto_reset = AutoReset::kSameStep;
  const auto batch = make(kId, options);
  batch->reset();
  std::vector<float> actions = test::zeros(*batch);
  const std::int64_t before = test::allocation_count();
  for (int t = 0; t < batch->info().horizon + 5; ++t) {
    ScriptedPolicy(*batch, Policy::kOracle).act(actions);
    batch->step(actions);
  }
  CHECK(test::allocation_count() == before);
}

TEST_CASE("Depth and segmentation can be had of other sizes and cameras", "[render][depth]") {
  BatchOptions options = seeing(ObsMode::kRgbDepthSegmentation, 1);
  options.images.width = 33;
  options.images.height = 20;
  options.images.cameras = {"render_camera", "base_camera", "hand_camera"};
  options.image_options.antialias = GENERATE(false, true);
  options.image_options.shadows = GENERATE(false, true);
  const auto batch = make(kId, options);
  batch->reset();
  REQUIRE(batch->images().depth.size() == 33 * 20 * 3);
  REQUIRE(batch->images().segmentation.size() == 33 * 20 * 3);
  options.images.cameras = {"base_camera"};
  options.image_options.antialias = options.image_options.shadows = false;
  const auto alone = make(kId, options);
  alone->reset();
  for (std::size_t i = 0; i < 33 * 20; ++i) {
    REQUIRE(batch->images().depth[3 * i + 1] == alone->images().depth[i]);
    REQUIRE(batch->images().segmentation[3 * i + 1] == alone->images().segmentation[i]);
  }
}

}  // namespace engram
