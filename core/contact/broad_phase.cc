#include "core/contact/broad_phase.h"

#include <algorithm>

#include "core/math/eigen_types.h"

namespace engram {
namespace {

constexpr double kRounding = 1e-9;  // m, margin for rounding errors

// Bounding sphere of all geoms of a body but planes, in its frame.
void enclose_body(const mjModel& model, int body, Vec3& center, double& radius) {
  const int first = model.body_geomadr[body];
  const int last = first + model.body_geomnum[body];
  Vec3 low = Vec3::Constant(mjMAXVAL);
  Vec3 high = Vec3::Constant(-mjMAXVAL);
  for (int geom = first; geom < last; ++geom) {
    if (model.geom_type[geom] == mjGEOM_PLANE) continue;
    const Eigen::Map<const Vec3> pos(model.geom_pos + 3 * geom);
    low = low.cwiseMin((pos.array() - model.geom_rbound[geom]).matrix());
    high = high.cwiseMax((pos.array() + model.geom_rbound[geom]).matrix());
  }
  center = 0.5 * (low + high);
  radius = 0;
  for (int geom = first; geom < last; ++geom) {
    if (model.geom_type[geom] == mjGEOM_PLANE) continue;
    const Eigen::Map<const Vec3> pos(model.geom_pos + 3 * geom);
    radius = std::max(radius, (pos - center).norm() + model.geom_rbound[geom]);
  }
  radius += kRounding;
}

}  // namespace

BroadPhase::BroadPhase(const mjModel& model) : model_(&model), filtered_model_(model) {
  for (int pair = 0; pair < model.npair; ++pair) add_pair(model, pair);
  centers_.resize(proxies_.size());

  const auto count = static_cast<std::size_t>(model.npair);
  for (std::vector<int>* column : {&dim_, &geom1_, &geom2_, &signature_}) column->resize(count);
  for (std::vector<mjtNum>* column : {&margin_, &gap_}) column->resize(count);
  solref_.resize(count * mjNREF);
  solimp_.resize(count * mjNIMP);
  friction_.resize(count * 5);
  filtered_model_.pair_dim = dim_.data();
  filtered_model_.pair_geom1 = geom1_.data();
  filtered_model_.pair_geom2 = geom2_.data();
  filtered_model_.pair_signature = signature_.data();
  filtered_model_.pair_solref = solref_.data();
  filtered_model_.pair_solimp = solimp_.data();
  filtered_model_.pair_margin = margin_.data();
  filtered_model_.pair_gap = gap_.data();
  filtered_model_.pair_friction = friction_.data();
}

int BroadPhase::proxy_of(const mjModel& model, int geom) {
  const bool plane = model.geom_type[geom] == mjGEOM_PLANE;
  const int body = model.geom_bodyid[geom];
  const auto found = std::find_if(proxies_.begin(), proxies_.end(), [&](const Proxy& proxy) {
    return plane ? proxy.plane == geom : proxy.plane < 0 && proxy.body == body;
  });
  if (found != proxies_.end()) return static_cast<int>(found - proxies_.begin());
  Proxy proxy;
  proxy.plane = plane ? geom : -1;
  proxy.body = body;
  if (!plane) enclose_body(model, body, proxy.center, proxy.radius);
  proxies_.push_back(proxy);
  return static_cast<int>(proxies_.size()) - 1;
}

void BroadPhase::add_pair(const mjModel& model, int pair) {
  int first = proxy_of(model, model.pair_geom1[pair]);
  int second = proxy_of(model, model.pair_geom2[pair]);
  const auto is_plane = [&](int proxy) {
    return proxies_[static_cast<std::size_t>(proxy)].plane >= 0;
  };
  if (is_plane(second)) std::swap(first, second);  // a plane comes first
  const bool same_proxies = !groups_.empty() && groups_.back().first_proxy == first &&
                            groups_.back().second_proxy == second;
  if (!same_proxies) groups_.push_back({first, second, pair, 0, 0});
  PairGroup& group = groups_.back();
  ++group.count;
  group.margin = std::max(group.margin, model.pair_margin[pair]);
}

bool BroadPhase::may_touch(const PairGroup& group, const mjData& data) const {
  const Proxy& first = proxies_[static_cast<std::size_t>(group.first_proxy)];
  const Proxy& second = proxies_[static_cast<std::size_t>(group.second_proxy)];
  const Vec3& center = centers_[static_cast<std::size_t>(group.second_proxy)];
  const double reach = first.radius + second.radius + group.margin;
  if (first.plane < 0) {
    const Vec3& other = centers_[static_cast<std::size_t>(group.first_proxy)];
    return (center - other).squaredNorm() <= reach * reach;
  }
  const mjtNum* pos = data.geom_xpos + 3 * first.plane;
  const mjtNum* axes = data.geom_xmat + 9 * first.plane;
  const Vec3 normal(axes[2], axes[5], axes[8]);
  return normal.dot(center - Eigen::Map<const Vec3>(pos)) <= reach;
}

void BroadPhase::append_pairs(const PairGroup& group) {
  const int at = filtered_model_.npair;
  const auto copy = [&](const auto* from, auto& to, int width) {
    std::copy_n(from + group.begin * width, group.count * width, to.data() + at * width);
  };
  copy(model_->pair_dim, dim_, 1);
  copy(model_->pair_geom1, geom1_, 1);
  copy(model_->pair_geom2, geom2_, 1);
  copy(model_->pair_signature, signature_, 1);
  copy(model_->pair_solref, solref_, mjNREF);
  copy(model_->pair_solimp, solimp_, mjNIMP);
  copy(model_->pair_margin, margin_, 1);
  copy(model_->pair_gap, gap_, 1);
  copy(model_->pair_friction, friction_, 5);
  filtered_model_.npair += group.count;
}

const mjModel* BroadPhase::near_pairs(const mjData& data) {
  for (std::size_t i = 0; i < proxies_.size(); ++i) {
    const Proxy& proxy = proxies_[i];
    if (proxy.plane >= 0) continue;
    const Eigen::Map<const Vec3> pos(data.xpos + 3 * proxy.body);
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> axes(data.xmat +
                                                                              9 * proxy.body);
    centers_[i] = pos + axes * proxy.center;
  }
  filtered_model_.npair = 0;
  for (const PairGroup& group : groups_) {
    if (may_touch(group, data)) append_pairs(group);
  }
  return &filtered_model_;
}

}  // namespace engram
