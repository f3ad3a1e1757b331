#include "tasks/trace_shape/info.h"

#include "tasks/common/lamp.h"
#include "tasks/common/smoothness.h"

namespace engram::tasks {

std::vector<std::pair<std::string, std::string>> trace_phases(const std::string& demo_end) {
  return {{"pre-demo", "elapsed < P; white lamp"},
          {"demo", "P <= elapsed < " + demo_end + "; red lamp"},
          {"action", "elapsed >= " + demo_end + "; green lamp"}};
}

std::string hidden_variable(const TraceParams& params) {
  const auto [least, most] = params.SHAPE_RADIUS_RANGE;
  if (params.AVAILABLE_SHAPES.size() > 1) return params.sequence ? "shapes" : "shape";
  if (least < most) return params.sequence ? "radii" : "radius";
  return params.sequence ? "rotations" : "rotation";
}

void add_trace_constants(const TraceParams& params, double success_bonus, ConstantTable& table) {
  add_lamp_constants(table);
  add_constants(params.smoothness, table);
  table.emplace_back("SUCCESS_BONUS", success_bonus);
}

}  // namespace engram::tasks
