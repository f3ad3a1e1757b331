#include "core/proximity.h"

#include <algorithm>

namespace engram {

bool sphere_reaches_geom(const mjModel& model, const mjData& data, int geom,
                         const Eigen::Vector3d& center, double radius) {
  const Eigen::Map<const Eigen::Vector3d> pos(data.geom_xpos + 3 * geom);
  const Eigen::Vector3d offset = center - pos;
  const double around = model.geom_rbound[geom] + radius;
  if (offset.squaredNorm() > around * around) return false;

  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> axes(data.geom_xmat +
                                                                            9 * geom);
  const Eigen::Vector3d local = axes.transpose() * offset;
  const mjtNum* size = model.geom_size + 3 * geom;
  switch (model.geom_type[geom]) {
    case mjGEOM_BOX: {
      const Eigen::Vector3d half(size[0], size[1], size[2]);
      return (local - local.cwiseMin(half).cwiseMax(-half)).squaredNorm() <= radius * radius;
    }
    case mjGEOM_CAPSULE: {
      const double along = std::clamp(local.z(), -size[1], size[1]);
      const double reach = radius + size[0];
      return (local - Eigen::Vector3d(0, 0, along)).squaredNorm() <= reach * reach;
    }
    default:
      return true;  // inside the bounding sphere: take it as near
  }
}

}  // namespace engram
