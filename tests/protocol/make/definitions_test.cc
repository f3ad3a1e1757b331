// Custom tasks are named by content, in settings and results, and two of one id are told apart.
#include "protocol/make/definitions.h"

#include <catch2/catch.hpp>

#include "protocol/custom_tasks/task_documents.h"
#include "protocol/eval/results/comparison.h"
#include "protocol/io/json_values.h"
#include "tasks/custom/custom_family.h"
#include "tests/protocol/eval/results/evaluation_documents.h"

namespace engram {
namespace {

using Catch::Contains;

constexpr const char* kId = "Defined-v0";

// A task that has nothing but its definition.
class EmptyInstance final : public tasks::CustomInstance {
 public:
  const tasks::CustomDescription& description() const override { return about_; }
  void bind(std::span<const tasks::CustomArray> /*arrays*/, int /*num_envs*/) override {}
  void call(tasks::CustomMethod /*method*/, int /*rows*/, bool /*of_all*/) override {}

 private:
  tasks::CustomDescription about_;
};

class EmptyFactory final : public tasks::CustomFactory {
 public:
  std::unique_ptr<tasks::CustomInstance> make(const std::string& /*id*/,
                                              const ConstantTable& /*constants*/) const override {
    return std::make_unique<EmptyInstance>();
  }
};

// Registers the task, with another text of its source.
std::string defined(const std::string& source) {
  tasks::register_custom(parse_definition(R"({"id": "Defined-v0", "family": "Defined", "horizon": 9,
                           "instruction": "Wait.", "source": ")" +
                                          source + "\"}"),
                         std::make_shared<EmptyFactory>());
  return text(definition_of(require_entry(kId)));
}

EvaluationSettings settings_of_task() {
  EvaluationSettings settings;
  settings.tasks = {kId, "RememberColor3-VLA-v0"};
  settings.policy = "mine";
  return settings;
}

TEST_CASE("Definitions are hashes of all that defines a task", "[own_tasks][definitions]") {
  const std::string first = defined("a");
  CHECK(first.size() == 64);
  CHECK(defined("a") == first);
  CHECK(defined("b") != first);
  CHECK(is_null(definition_of(require_entry("RememberColor3-VLA-v0"))));
  const TaskVariant variant = {.id = "Defined-Longer-v0", .base = kId};
  register_variants({&variant, 1});
  CHECK((definition_of(require_entry(variant.id)) == definition_of(require_entry(kId))));
}

TEST_CASE("Settings of another definition are refused", "[own_tasks][definitions]") {
  const std::string first = defined("a");
  const Json document = settings_of_task().document();
  CHECK((part(document, "definitions") == Json(JsonTable{{kId, first}})));
  CHECK((EvaluationSettings::of(document, "settings.json").document() == document));
  const std::string other = defined("b");
  CHECK_THROWS_WITH(EvaluationSettings::of(document, "settings.json"),
                    Contains(kId) && Contains(first.substr(0, 8) + " in 'settings.json'") &&
                        Contains(other.substr(0, 8) + " in this process"));
}

TEST_CASE("Documents of built-in tasks have no definitions", "[definitions]") {
  EvaluationSettings settings = settings_of_task();
  settings.tasks = {"RememberColor3-VLA-v0"};
  CHECK(find(settings.document(), "definitions") == nullptr);
  CHECK(find(test::task_of("RememberColor3-VLA-v0", {true}), "definition") == nullptr);
}

TEST_CASE("Results of two definitions are not compared", "[own_tasks][definitions]") {
  const std::string first = defined("a");
  const ResultSet a{"a", {test::task_of(kId, {true, false})}};
  const std::string other = defined("b");
  const ResultSet b{"b", {test::task_of(kId, {true, true})}};
  CHECK_THROWS_WITH(compare_results(a, b, {}),
                    Contains(kId) && Contains(first.substr(0, 8)) && Contains(other.substr(0, 8)));
  CHECK_NOTHROW(compare_results(a, b, {AllowedDifference::kConstants}));
  CHECK_NOTHROW(compare_results(a, a, {}));
}

}  // namespace
}  // namespace engram
