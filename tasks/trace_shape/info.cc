#include "tasks/trace_shape/info.h"

namespace engram::tasks {

std::vector<std::pair<std::string, std::string>> trace_phases(const std::string& demo_end) {
  return {{"pre-demo", "elapsed < P; white lamp"},
          {"demo", "P <= elapsed < " + demo_end + "; red lamp"},
          {"action", "elapsed >= " + demo_end + "; green lamp"}};
}

std::string hidden_variable(const TraceParams& params) {
  const bool sizes_vary = params.SHAPE_RADIUS_RANGE.low < params.SHAPE_RADIUS_RANGE.high;
  if (params.AVAILABLE_SHAPES.size() > 1) return params.sequence ? "shapes" : "shape";
  if (sizes_vary) return params.sequence ? "radii" : "radius";
  return params.sequence ? "rotations" : "rotation";
}

}  // namespace engram::tasks
