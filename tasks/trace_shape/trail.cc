#include "tasks/trace_shape/trail.h"

#include <algorithm>
#include <numeric>
#include <span>

namespace engram::tasks {
namespace {

// inside: by checkpoint, how far inside its reach a trail has been, m.
void approach(const Contour& contour, const Vec2& at, std::span<double> inside) {
  const double reach = contour.set().reach();
  int checkpoint = 0;
  for (double& depth : inside) {
    depth = std::max(depth, reach - (contour.checkpoint(checkpoint++) - at).norm());
  }
}

}  // namespace

void Trail::bind(ColumnStore& memory, const TraceDemo& demo) {
  inside_ =
      memory.add<double>("trail_inside", demo.candidates() * demo.contours().checkpoints(), "m");
  committed_ = memory.add<std::uint8_t>("trail_committed");
}

int Trail::follow(int env, const TraceDemo& demo, int element) const {
  if (committed_[env] != 0) return -1;
  const Vec2 at = demo.green_at(env);
  const auto checkpoints = static_cast<std::size_t>(demo.contours().checkpoints());
  bool closed = false;
  int nearest = -1;
  double most = 0;
  for (int i = 0; i < demo.candidates(); ++i) {
    const Contour candidate = demo.candidate(env, element, i);
    const std::span inside(inside_.row(env) + static_cast<std::size_t>(i) * checkpoints,
                           checkpoints);
    approach(candidate, at, inside);
    closed |= std::ranges::all_of(inside, [](double depth) { return depth > 0; }) &&
              (candidate.checkpoint(0) - at).norm() < candidate.set().reach();
    const double sum = std::accumulate(inside.begin(), inside.end(), 0.0);
    if (sum <= most) continue;
    most = sum;
    nearest = candidate.shape();
  }
  if (!closed) return -1;
  committed_[env] = 1;
  return nearest;
}

void Trail::forget(int env) const {
  std::fill_n(inside_.row(env), inside_.width(), 0.0);
  committed_[env] = 0;
}

}  // namespace engram::tasks
