#include "protocol/eval/run/settings.h"

#include <catch2/catch.hpp>

#include "protocol/io/json_checksum.h"
#include "protocol/io/json_values.h"

namespace engram {
namespace {

EvaluationSettings example() {
  EvaluationSettings settings;
  settings.tasks = {"RememberColor3-VLA-v0", "TakeItBack-VLA-v0"};
  settings.episodes = 7;
  settings.start_seed = UINT64_MAX;
  settings.policy = "mine";
  settings.policy_config = JsonTable{{"layers", 3}};
  MakeOptions environment;
  environment.obs_mode = ObsMode::kRgb;
  environment.image_options.renderer = "egl";
  environment.rules = Rules::kOriginal;
  environment.task_options = {{"touch_radius", 0.03}};
  environment.constants = {{"COLORS", 8}, {"EMPTY_PHASE_STEPS", ConstantList{1, 3}}};
  environment.perturbations = {{PerturbationAxis::kLight, 0.25}};
  settings.set_environment(environment);
  return settings;
}

// The document without this entry, or with another value in it, and the checksum of that.
Json edited(const Json& document, std::string_view key, std::optional<Json> value) {
  JsonTable all = table(document);
  all.pop_back();
  if (value) {
    for (auto& [name, old] : all) {
      if (name == key) old = *value;
    }
  } else {
    std::erase_if(all, [key](const auto& entry) { return entry.first == key; });
  }
  add_checksum(all);
  return all;
}

TEST_CASE("Settings survive their document", "[evaluation][settings]") {
  const Json document = example().document();
  CHECK((EvaluationSettings::of(document, "settings.json").document() == document));
  CHECK(text(part(document, "obs_mode")) == "rgb");
  CHECK(text(part(document, "renderer")) == "egl");
  CHECK(text(part(document, "rules")) == "original");
  const auto refuse = [](const Json& damaged, const auto& words) {
    CHECK_THROWS_WITH(EvaluationSettings::of(damaged, "settings.json"), words);
  };
  using Catch::Contains;
  refuse(edited(document, "task_options", std::nullopt),
         Contains("settings.json") && Contains("no 'task_options'"));
  refuse(edited(document, "perturbations", JsonTable{{"smell", 1}}),
         Contains("settings.json") && Contains("no axis of perturbations named 'smell'"));
  refuse(edited(document, "perturbations", JsonTable{{"light", 1.5}}),
         Contains("settings.json") && Contains("'light'") && Contains("1.5"));
  refuse(edited(document, "perturbations", JsonList{"light"}), Contains("settings.json"));
  refuse(edited(document, "obs_mode", "pixels"),
         Contains("'pixels'") && Contains("state_dict, rgb"));
  refuse(edited(document, "rules", "none"),
         Contains("no rules named 'none'; allowed are: reference, original"));
  JsonTable by_hand = table(document);
  by_hand[2].second = 8;  // n_episodes
  refuse(by_hand, Contains("its checksum does not fit"));
}

TEST_CASE("Settings without a key for perturbations have none", "[evaluation][settings]") {
  const Json older = edited(example().document(), "perturbations", std::nullopt);
  CHECK(EvaluationSettings::of(older, "settings.json").perturbations.empty());
}

TEST_CASE("Settings name the physics, and MuJoCo's version where it is MuJoCo's",
          "[evaluation][settings]") {
  EvaluationSettings settings = example();
  CHECK(text(part(settings.document(), "physics")) == "engram");
  CHECK(is_null(value_or_null(settings.document(), "mujoco_version")));
  const Json older = edited(settings.document(), "physics", std::nullopt);
  CHECK(EvaluationSettings::of(older, "settings.json").physics == Physics::kEngram);

  settings.physics = Physics::kMujoco;
  const Json document = settings.document();
  const EvaluationSettings read = EvaluationSettings::of(document, "settings.json");
  CHECK((read.document() == document));
  CHECK(protocol_of(read).environment.physics == Physics::kMujoco);
  CHECK_THROWS_WITH(
      EvaluationSettings::of(edited(document, "mujoco_version", "1.0.0"), "settings.json"),
      Catch::Contains("mujoco_version is \"1.0.0\", here"));
  CHECK_THROWS_WITH(EvaluationSettings::of(edited(document, "physics", "bullet"), "settings.json"),
                    Catch::Contains("no physics named 'bullet'; allowed are: engram, mujoco"));
}

TEST_CASE("Settings of another version are refused by its name", "[evaluation][settings]") {
  JsonTable other = table(example().document());
  REQUIRE(other.front().first == "version");
  other.front().second = "99.0.0";
  CHECK_THROWS_WITH(EvaluationSettings::of(other, "settings.json"),
                    Catch::Contains("settings.json") && Catch::Contains("of engram 99.0.0") &&
                        Catch::Contains("another folder"));
  other.erase(other.begin());
  CHECK_THROWS_WITH(EvaluationSettings::of(other, "settings.json"),
                    Catch::Contains("of engram 0.1.0 or older"));
}

TEST_CASE("Settings of a sealed run have no seed before it is opened", "[evaluation][settings]") {
  const std::string secret(40, 's');
  EvaluationSettings settings = example();
  settings.set_commitment(SeedCommitment(secret));
  CHECK(protocol_of(settings).start_seed == SeedCommitment(secret).start_seed());
  CHECK(protocol_of(settings).number_key == secret);
  const Json closed = settings.document();
  CHECK(is_null(part(closed, "start_seed")));
  CHECK_THAT(to_text(closed),
             !Catch::Contains(secret) && !Catch::Contains(std::to_string(settings.start_seed)));
  const EvaluationSettings read = EvaluationSettings::of(closed, "settings.json");
  CHECK_FALSE(read.commitment->has_secret());
  CHECK((read.document() == closed));

  settings.revealed = true;
  const Json revealed = settings.document();
  CHECK((EvaluationSettings::of(revealed, "settings.json").document() == revealed));
  CHECK(EvaluationSettings::of(revealed, "settings.json").start_seed == settings.start_seed);
  const Json lying =
      JsonTable{{"sha256", SeedCommitment(std::string(40, 'x')).hash()}, {"secret", secret}};
  CHECK_THROWS_WITH(EvaluationSettings::of(edited(revealed, "sealed", lying), "settings.json"),
                    Catch::Contains("the hash is not that of the secret seed"));
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
  REQUIRE(protocol.environment.perturbations.size() == 1);
  CHECK(protocol.environment.perturbations[0].axis == PerturbationAxis::kLight);
  CHECK(protocol.environment.perturbations[0].level == 0.25);
}

TEST_CASE("Ids are in the registry's order", "[evaluation][settings]") {
  const RegistryEntry& first = registry().front();
  const RegistryEntry& last = registry().back();
  CHECK(ids_in_order({&last, &first}) ==
        std::vector<std::string>{std::string(first.id), std::string(last.id)});
  CHECK(ids_in_order({}).empty());
}

TEST_CASE("Settings of before there were repeats have their defaults", "[evaluation][settings]") {
  EvaluationSettings settings = example();
  settings.repeat = 3;
  settings.policy_seed = UINT64_MAX;
  settings.latency = 4;
  Json document = settings.document();
  CHECK((EvaluationSettings::of(document, "settings.json").document() == document));
  CHECK(protocol_of(settings).all_episodes() == 21);
  CHECK(protocol_of(settings).latency == 4);
  for (const char* key : {"repeat", "policy_seed", "latency_steps"}) {
    document = edited(document, key, std::nullopt);
  }
  const EvaluationSettings older = EvaluationSettings::of(document, "settings.json");
  CHECK((older.document() == example().document()));
  CHECK_THROWS_WITH(
      EvaluationSettings::of(edited(settings.document(), "repeat", 0), "settings.json"),
      Catch::Contains("'repeat' is 0"));
}

TEST_CASE("Latencies are steps, or milliseconds rounded up", "[evaluation][latency]") {
  CHECK(parse_latency("--latency", "0") == 0);
  CHECK(parse_latency("--latency", "3") == 3);
  CHECK(parse_latency("--latency", "0ms") == 0);
  CHECK(parse_latency("--latency", "50ms") == 1);
  CHECK(parse_latency("--latency", "50.5ms") == 2);
  CHECK(parse_latency("--latency", "1000000") == 1'000'000);
  for (const char* bad : {"", "ms", "-1", "1.5", "3 steps", "120 ms", "1e3", "nan", "1000001",
                          "99999999ms", "0x3", "1.2.3ms", "+3"}) {
    INFO(bad);
    CHECK_THROWS_WITH(parse_latency("--latency", bad),
                      Catch::Contains("--latency: '" + std::string(bad) + "' given, 0 to 1000000"));
  }
}

}  // namespace
}  // namespace engram
