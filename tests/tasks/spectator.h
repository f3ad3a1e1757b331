// What tests see of one environment while others play: poses, speeds and info fields, as anyone
// outside the task can read them.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/batch/batch.h"
#include "core/batch/queries.h"

namespace engram::test {

using Point = Eigen::Vector3d;

inline double horizontal(const Point& a, const Point& b) { return (a - b).head<2>().norm(); }

class Spectator {
 public:
  Spectator(const Batch& batch, int index) : batch_(&batch), index_(index) {}

  const State& state() const { return batch_->state(); }
  int index() const { return index_; }
  int elapsed() const { return state().elapsed[index_]; }
  bool finished() const { return state().finished[index_] != 0; }
  bool success() const { return batch_->outputs().success[static_cast<std::size_t>(index_)] != 0; }

  int num_props() const { return state().num_props; }
  const std::string& prop_name(int prop) const {
    return batch_->physics_model().props()[static_cast<std::size_t>(prop)].name;
  }
  int prop(std::string_view name) const {
    for (int i = 0; i < num_props(); ++i) {
      if (prop_name(i) == name) return i;
    }
    FAIL("no prop " << name << " in " << batch_->info().id);
    return 0;
  }
  // Props whose names begin like that, in order.
  std::vector<int> props(std::string_view prefix) const {
    std::vector<int> found;
    for (int i = 0; i < num_props(); ++i) {
      if (prop_name(i).starts_with(prefix)) found.push_back(i);
    }
    return found;
  }
  Point pos(int prop) const { return Point(state().prop_pos_of(index_, prop)); }
  Point pos(std::string_view name) const { return pos(prop(name)); }
  double speed(int prop) const { return Point(state().prop_qvel_of(index_, prop)).norm(); }
  Eigen::Matrix3d rotation(std::string_view name) const {
    return matrix(state().prop_quat_of(index_, prop(name)));
  }
  bool hidden(int prop) const { return state().status_of(index_, prop) == PropStatus::kHidden; }

  Point tcp() const { return Point(state().tcp_pos.row(index_)); }
  Eigen::Matrix3d tcp_rotation() const { return matrix(state().tcp_quat.row(index_)); }
  // Speed of the fastest of the seven arm joints.
  double fastest_joint() const {
    const double* qvel = state().qvel.row(index_);
    return std::abs(*std::max_element(
        qvel, qvel + 7, [](double a, double b) { return std::abs(a) < std::abs(b); }));
  }
  bool still(double threshold = 0.2) const { return fastest_joint() <= threshold; }
  // Force of a prop on a finger, N, world.
  Point force(int prop, int finger) const {
    return Point(state().finger_force.row(index_) + 3 * (2 * prop + finger));
  }

  // An info field, whatever its type.
  double info(std::string_view name, int component = 0) const {
    const ColumnView view = batch_->output(name);
    const std::byte* row = view.row(index_);
    switch (view.field->dtype) {
      case DType::kBool:
        return reinterpret_cast<const std::uint8_t*>(row)[component];
      case DType::kInt32:
        return reinterpret_cast<const std::int32_t*>(row)[component];
      case DType::kFloat32:
        return static_cast<double>(reinterpret_cast<const float*>(row)[component]);
      case DType::kFloat64:
        return reinterpret_cast<const double*>(row)[component];
      default:
        FAIL("info field " << name << " has a type of its own");
        return 0;
    }
  }
  int width(std::string_view name) const { return batch_->output(name).field->width; }
  int info_int(std::string_view name, int component = 0) const {
    return static_cast<int>(std::lround(info(name, component)));
  }
  // Where a field of the state observation begins.
  const float* observed(std::string_view name) const {
    int offset = 0;
    for (const Field& field : Queries(*batch_).state_fields()) {
      if (field.name == name)
        return batch_->outputs().observation.data() + index_ * batch_->state_dim() + offset;
      offset += field.width;
    }
    FAIL("no state field " << name << " in " << batch_->info().id);
    return nullptr;
  }

 private:
  static Eigen::Matrix3d matrix(const double* quat) {
    return Eigen::Quaterniond(quat[0], quat[1], quat[2], quat[3]).toRotationMatrix();
  }

  const Batch* batch_;
  int index_;
};

}  // namespace engram::test
