// What probes of memory know of the tasks.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <string_view>
#include <variant>

#include "core/task/answer_controller.h"
#include "core/task/task.h"
#include "tasks/registry.h"

namespace engram {
namespace {

bool has_range(const TaskInfo& info, std::string_view name) {
  const auto found = std::ranges::find(info.constants, name, &TaskConstant::name);
  return found != info.constants.end() && std::holds_alternative<ConstantList>(found->value.value);
}

bool has_draw(const TaskInfo& info, std::string_view name) {
  return std::ranges::find(info.random_variables, name, &RandomVariable::name) !=
         info.random_variables.end();
}

bool has_whole_number(const TaskInfo& info, std::string_view name) {
  const auto found = std::ranges::find(info.constants, name, &TaskConstant::name);
  return found != info.constants.end() &&
         std::holds_alternative<std::int64_t>(found->value.value) && found->changeable();
}

TEST_CASE("Constants and draws that probes vary are those of every task", "[probe][families]") {
  for (const RegistryEntry& entry : registry()) {
    INFO(entry.id);
    const TaskInfo info = make_task(entry.id)->info();
    const MemoryFacts& facts = entry.definition->memory;
    CHECK((facts.delay.empty() || has_range(info, facts.delay)));
    CHECK((facts.items.empty() || has_whole_number(info, facts.items) ||
           has_draw(info, facts.items)));
    CHECK((facts.irrelevant == CounterfactualChange::kDraw) == !facts.irrelevant_draw.empty());
    CHECK((facts.irrelevant_draw.empty() || has_draw(info, facts.irrelevant_draw)));
    if (facts.no_counterfactuals.empty()) {
      CHECK(has_draw(info, facts.hidden.empty() ? info.hidden_variable : facts.hidden));
    }
    if (facts.cue_by_hand) CHECK(answer_controller_of(*make_task(entry.id)) != nullptr);
  }
}

}  // namespace
}  // namespace engram
