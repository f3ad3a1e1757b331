#include "protocol/evaluation/settings.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

EvaluationSettings example() {
  EvaluationSettings settings;
  settings.tasks = {"RememberColor3-VLA-v0", "TakeItBack-VLA-v0"};
  settings.episodes = 7;
  settings.start_seed = UINT64_MAX;
  settings.policy = "mine";
  settings.policy_config = DocumentTable{{"layers", 3}};
  MakeOptions environment;
  environment.obs_mode = ObsMode::kRgb;
  environment.image_options.renderer = "egl";
  environment.rules = Rules::kOriginal;
  environment.task_options = {{"touch_radius", 0.03}};
  environment.constants = {{"COLORS", 8}, {"EMPTY_PHASE_STEPS", ConstantList{1, 3}}};
  settings.set_environment(environment);
  return settings;
}

TEST_CASE("Settings survive their document", "[evaluation][settings]") {
  const Document document = example().document();
  CHECK((EvaluationSettings::of(document, "settings.json").document() == document));
  CHECK(text(part(document, "obs_mode")) == "rgb");
  CHECK(text(part(document, "renderer")) == "egl");
  CHECK(text(part(document, "rules")) == "original");
  DocumentTable lacking = table(document);
  std::erase_if(lacking, [](const auto& entry) { return entry.first == "task_options"; });
  CHECK_THROWS_WITH(EvaluationSettings::of(lacking, "settings.json"),
                    Catch::Contains("settings.json") && Catch::Contains("no 'task_options'"));
  DocumentTable unknown = table(document);
  for (auto& [key, value] : unknown) {
    if (key == "obs_mode") value = "pixels";
  }
  CHECK_THROWS_WITH(EvaluationSettings::of(unknown, "settings.json"),
                    Catch::Contains("'pixels'") && Catch::Contains("state_dict, rgb"));
  DocumentTable lawless = table(document);
  for (auto& [key, value] : lawless) {
    if (key == "rules") value = "none";
  }
  CHECK_THROWS_WITH(EvaluationSettings::of(lawless, "settings.json"),
                    Catch::Contains("no rules named 'none'; allowed are: reference, original"));
}

TEST_CASE("Settings of another version are refused by its name", "[evaluation][settings]") {
  DocumentTable other = table(example().document());
  REQUIRE(other.front().first == "version");
  other.front().second = "99.0.0";
  CHECK_THROWS_WITH(EvaluationSettings::of(other, "settings.json"),
                    Catch::Contains("settings.json") && Catch::Contains("of engram 99.0.0") &&
                        Catch::Contains("another folder"));
  other.erase(other.begin());
  CHECK_THROWS_WITH(EvaluationSettings::of(other, "settings.json"),
                    Catch::Contains("of engram 0.1.0 or older"));
}

TEST_CASE("Settings name no renderer without images", "[evaluation][settings]") {
  EvaluationSettings settings = example();
  MakeOptions environment;
  environment.obs_mode = ObsMode::kState;
  environment.image_options.renderer = "egl";
  settings.set_environment(environment);
  CHECK(settings.obs_mode == ObsMode::kState);
  CHECK(settings.renderer == "none");
  CHECK(settings.task_options.empty());
  CHECK(protocol_of(settings).environment.image_options.renderer == "cpu");
}

TEST_CASE("A protocol has the values of the settings", "[evaluation][settings]") {
  const Protocol protocol = protocol_of(example());
  CHECK(protocol.episodes == 7);
  CHECK(protocol.start_seed == UINT64_MAX);
  CHECK(protocol.environment.obs_mode == ObsMode::kRgb);
  CHECK(protocol.environment.image_options.renderer == "egl");
  CHECK(protocol.environment.rules == Rules::kOriginal);
  REQUIRE(protocol.environment.task_options.size() == 1);
  CHECK(protocol.environment.task_options[0].name == "touch_radius");
  CHECK(protocol.environment.task_options[0].value == 0.03);
}

TEST_CASE("Ids are in the registry's order", "[evaluation][settings]") {
  const RegistryEntry& first = registry().front();
  const RegistryEntry& last = registry().back();
  CHECK(ids_in_order({&last, &first}) ==
        std::vector<std::string>{std::string(first.id), std::string(last.id)});
  CHECK(ids_in_order({}).empty());
}

}  // namespace
}  // namespace engram
