#include "tasks/trace_shape/info.h"

#include "tasks/trace_shape/rewards.h"

namespace engram::tasks {

int trace_shapes_of(std::string_view id) {
  if (id.find("Easy") != std::string_view::npos) return 1;
  return id.find("Medium") != std::string_view::npos ? 2 : 3;
}

std::vector<std::pair<std::string, std::string>> trace_phases(const std::string& demo_end) {
  return {{"pre-demo", "elapsed < P; white lamp"},
          {"demo", "P <= elapsed < " + demo_end + "; red lamp"},
          {"action", "elapsed >= " + demo_end + "; green lamp"}};
}

void add_trace_constants(double success_bonus, ConstantTable& table) {
  add_lamp_constants(table);
  add_constants(kTraceSmoothness, table);
  table.emplace_back("SUCCESS_BONUS", success_bonus);
}

}  // namespace engram::tasks
