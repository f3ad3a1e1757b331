#include "core/task/task_constant.h"

#include "core/base/join.h"

namespace engram {
namespace {

struct InWords {
  std::string operator()(std::nullptr_t) const { return "null"; }
  std::string operator()(bool value) const { return value ? "true" : "false"; }
  std::string operator()(std::int64_t value) const { return std::to_string(value); }
  std::string operator()(std::uint64_t value) const { return std::to_string(value); }
  std::string operator()(double value) const { return shortest(value); }
  std::string operator()(const std::string& value) const { return "'" + value + "'"; }
  std::string operator()(const ConstantList& value) const {
    return "[" + join(value, in_words) + "]";
  }
  std::string operator()(const ConstantTable& value) const {
    return "{" +
           join(value,
                [](const auto& entry) { return entry.first + ": " + in_words(entry.second); }) +
           "}";
  }
};

}  // namespace

ConstantTable published_constants(const std::vector<TaskConstant>& constants) {
  ConstantTable table;
  for (const TaskConstant& constant : constants) {
    if (!constant.published) continue;
    table.emplace_back(constant.name, constant.published_form());
  }
  return table;
}

ConstantTable changed_constants(const std::vector<TaskConstant>& constants) {
  ConstantTable table;
  for (const TaskConstant& constant : constants) {
    if (constant.changed) table.emplace_back(constant.name, constant.value);
  }
  return table;
}

std::optional<double> as_number(const Constant& constant) {
  if (const auto* value = std::get_if<std::int64_t>(&constant.value)) {
    return static_cast<double>(*value);
  }
  if (const auto* value = std::get_if<std::uint64_t>(&constant.value)) {
    return static_cast<double>(*value);
  }
  if (const auto* value = std::get_if<double>(&constant.value)) return *value;
  return std::nullopt;
}

std::string in_words(const Constant& constant) { return std::visit(InWords{}, constant.value); }

}  // namespace engram
