// Probes as a whole: what they find of policies whose memory is known.
#include "protocol/eval/probe/probe_run.h"

#include <catch2/catch.hpp>
#include <map>
#include <memory>
#include <set>
#include <string>

#include "protocol/eval/probe/probe_report.h"
#include "tests/protocol/eval/probe/remembering_policy.h"

namespace engram {
namespace {

constexpr const char* kShell = "ShellGameTouch-VLA-v0";

EvaluationSettings settings_for(const std::vector<std::string>& ids, int episodes) {
  EvaluationSettings settings;
  settings.tasks = ids;
  settings.episodes = episodes;
  settings.policy = "oracle";
  settings.obs_mode = ObsMode::kObjects;
  return settings;
}

Json probe(const EvaluationSettings& settings, Policy policy, const ProbeOptions& options,
           int threads = 1, int num_envs = 4) {
  Protocol protocol = protocol_of(settings);
  protocol.policy = policy;
  protocol.threads = threads;
  protocol.num_envs = num_envs;
  return run_probes(settings, protocol, options, {});
}

Json probe_external(const EvaluationSettings& settings, bool remembers, const ProbeOptions& options,
                    int threads = 1, int num_envs = 4) {
  Protocol protocol = protocol_of(settings);
  protocol.external = [remembers](const WorkContext& /*context*/) {
    return std::make_unique<test::RememberingPolicy>(remembers);
  };
  protocol.threads = threads;
  protocol.num_envs = num_envs;
  return run_probes(settings, protocol, options, {});
}

const Json& section(const Json& document, const char* probe, std::size_t task = 0) {
  return part(list(part(document, "tasks")).at(task), probe);
}

double rate(const Json& table, const char* share) {
  return number(part(part(table, share), "rate"));
}

bool all_equal(const Json& presents) {
  const double compared = number(part(presents, "compared"));
  return compared > 0 && number(part(presents, "equal")) == compared;
}

const Json& point(const Json& section, std::size_t i) {
  return list(part(section, "points")).at(i);
}

// --- twins ---

// One id of each family with twins.
const std::vector<std::string> kWithTwins = {"ShellGameTouch-VLA-v0",
                                             "ShellGamePush-VLA-v0",
                                             "ShellGamePick-VLA-v0",
                                             "ShellGameColorLampTouch-VLA-v0",
                                             "ShellGameShuffleTouch-VLA-v0",
                                             "ShellGameShuffleColorLampTouch-VLA-v0",
                                             "RememberColor3-VLA-v0",
                                             "RememberShape3-VLA-v0",
                                             "RememberShapeAndColor3x2-VLA-v0",
                                             "FindImposterColor3-VLA-v0",
                                             "FindImposterShape3-VLA-v0",
                                             "FindImposterShapeAndColor3x2-VLA-v0",
                                             "SeqOfColors3-VLA-v0",
                                             "ChainOfColors3-VLA-v0",
                                             "BunchOfColors3-VLA-v0",
                                             "TraceShapeMedium-VLA-v0",
                                             "TraceShapeSeqMedium-VLA-v0",
                                             "TraceShapeSeqEasy-VLA-v0",
                                             "TakeItBack-v0",
                                             "GatherAndRecall1-VLA-v0",
                                             "BlinkCountButtonPressEasy-VLA-v0"};

TEST_CASE("The oracle follows every past, and presents are the same to the bit", "[probe]") {
  const Json document =
      probe(settings_for(kWithTwins, 2), Policy::kOracle, {.probes = {Probe::kTwins}});
  for (std::size_t i = 0; i < kWithTwins.size(); ++i) {
    INFO(kWithTwins[i]);
    const Json& twins = section(document, "twins", i);
    REQUIRE(find(twins, "skipped") == nullptr);
    CHECK(number(part(twins, "pairs")) == 2);
    CHECK(all_equal(part(twins, "presents")));
    CHECK(all_equal(part(twins, "stay_presents")));
    CHECK(rate(twins, "follow") == 1);
    CHECK(rate(twins, "stay") == 1);
    // It reads the scene, not a memory.
    CHECK(rate(part(twins, "swapped"), "scene") == 1);
    CHECK(rate(part(twins, "swapped"), "past") == 0);
  }
}

TEST_CASE("Where constants leave a past nothing to change, the arm has started elsewhere",
          "[probe]") {
  const std::map<std::string, std::string> changes = {
      {"RememberColor3-VLA-v0", "cue_steps"},
      {"RememberColor5-Long-VLA-v0", kRobotNoiseVariable},
      {"RememberColor3-v0", kRobotNoiseVariable},
      {"ShellGamePush-v0", kRobotNoiseVariable},
      {"ChainOfColors3-v0", kRobotNoiseVariable},
      {"ChainOfColors3-VLA-v0", "cue_step_duration"},
      // The least change of its cue is longer than the range of its delay.
      {"ChainOfColors5-VLA-v0", kRobotNoiseVariable},
      {"SeqOfColors3-v0", "order of sequence"},
      {"TakeItBack-v0", kRobotNoiseVariable},
      {"ShellGameColorLampTouch-VLA-v0", "mapping"}};
  for (const auto& [id, change] : changes) {
    INFO(id);
    EvaluationSettings settings = settings_for({id}, 1);
    settings.control_mode = make_task(id)->info().control_mode;
    const Json document = probe(settings, Policy::kOracle, {.probes = {Probe::kTwins}});
    const Json& twins = section(document, "twins");
    CHECK(text(part(twins, "stay_by")) == change);
    CHECK(all_equal(part(twins, "stay_presents")));
    CHECK(rate(twins, "stay") == 1);
  }
  // With a start pose that does not vary, there is nothing left.
  EvaluationSettings settings = settings_for({"RememberColor5-Long-VLA-v0"}, 1);
  settings.constants = {{"robot_init_qpos_noise", 0.0}};
  const Json document = probe(settings, Policy::kOracle, {.probes = {Probe::kTwins}});
  CHECK(is_null(part(section(document, "twins"), "stay")));
  CHECK(is_null(part(section(document, "twins"), "stay_by")));
}

// Notes the arm's joints in the last request before each trial's question, and after it.
class JointsPolicy final : public ExternalPolicy {
 public:
  using Joints = std::map<std::int32_t, std::vector<std::vector<float>>>;
  explicit JointsPolicy(Joints& joints) : joints_(joints) {}

  void act(const PolicyRequest& request, PolicyReply& reply) override {
    const std::int64_t shape[] = {7};
    for (int row = 0; row < request.count; ++row) {
      const auto i = static_cast<std::size_t>(row);
      const float* seen = request.state.data() + i * static_cast<std::size_t>(request.state_dim);
      joints_[request.numbers[i]].emplace_back(seen, seen + 7);
      reply.set(row, std::vector<float>(7), shape);
    }
  }

 private:
  Joints& joints_;
};

TEST_CASE("A past with another start pose is seen, and ends in the scene of the first", "[probe]") {
  JointsPolicy::Joints joints;
  Protocol protocol = protocol_of(settings_for({"RememberColor5-Long-VLA-v0"}, 1));
  protocol.external = [&joints](const WorkContext& /*context*/) {
    return std::make_unique<JointsPolicy>(joints);
  };
  protocol.threads = 1;
  (void)run_probes(settings_for({"RememberColor5-Long-VLA-v0"}, 1), protocol,
                   {.probes = {Probe::kTwins}}, {});
  // All trials but one begin alike.
  std::map<std::vector<float>, int> starts;
  std::set<std::vector<float>> ends;
  for (const auto& [number, seen] : joints) {
    ++starts[seen.front()];
    ends.insert(seen.back());
  }
  REQUIRE(starts.size() == 2);
  CHECK(std::min(starts.begin()->second, starts.rbegin()->second) == 1);
  CHECK(ends.size() == 1);
}

TEST_CASE("A cue that the robot works with ends with the hand's question", "[probe]") {
  const EvaluationSettings settings = settings_for({"TakeItBack-v0"}, 6);
  const Json oracle = probe(settings, Policy::kOracle, {.probes = {Probe::kTwins}});
  const Json blind = probe(settings, Policy::kBlind, {.probes = {Probe::kTwins}});
  const Json& seen = section(oracle, "twins");
  // Presents of exchanged scenes and of wiped trials alone are compared.
  CHECK(number(part(part(seen, "presents"), "compared")) == 24);
  CHECK(rate(seen, "answered") == 1);
  const Json& guessed = section(blind, "twins");
  CHECK(all_equal(part(guessed, "presents")));
  CHECK(rate(guessed, "both_follow") == 0);
  CHECK(rate(guessed, "follow") < 0.7);
  CHECK(rate(guessed, "stay") == 1);
}

// The hand stops before the arm is straight, and where no way leads past another place.
TEST_CASE("A cue that the robot works with leaves every answer open", "[probe]") {
  const EvaluationSettings settings = settings_for({"TakeItBack-VLA-v0"}, 24);
  const Json oracle = probe(settings, Policy::kOracle, {.probes = {Probe::kTwins}});
  const Json& twins = section(oracle, "twins");
  CHECK(rate(twins, "answered") == 1);
  CHECK(rate(twins, "follow") == 1);
  CHECK(rate(part(twins, "swapped"), "scene") == 1);
}

TEST_CASE("Presents are the same in images, too", "[probe][render]") {
  EvaluationSettings settings =
      settings_for({"ShellGameTouch-VLA-v0", "FindImposterColor3-VLA-v0", "GatherAndRecall1-VLA-v0",
                    "BlinkCountButtonPressEasy-VLA-v0"},
                   1);
  settings.obs_mode = ObsMode::kRgb;
  settings.renderer = "cpu";
  const Json document = probe(settings, Policy::kOracle, {.probes = {Probe::kTwins}});
  for (std::size_t i = 0; i < settings.tasks.size(); ++i) {
    INFO(settings.tasks[i]);
    CHECK(all_equal(part(section(document, "twins", i), "presents")));
  }
}

TEST_CASE("An observation that tells what is hidden makes presents differ", "[probe]") {
  EvaluationSettings settings = settings_for({kShell}, 3);
  settings.obs_mode = ObsMode::kState;
  const Json document = probe(settings, Policy::kOracle, {.probes = {Probe::kTwins}});
  const Json& presents = part(section(document, "twins"), "presents");
  CHECK(number(part(presents, "compared")) == 15);
  // Presents of a wiped trial, and of a scene that takes the other's place, have one past.
  CHECK(number(part(presents, "equal")) < 15);
}

TEST_CASE("Every family either has twins or says why not", "[probe]") {
  std::set<std::string_view> families;
  for (const std::string& id : kWithTwins) families.insert(require_entry(id).family);
  for (const RegistryEntry& entry : registry()) {
    INFO(entry.id);
    CHECK(families.contains(entry.family) == entry.definition->memory.no_counterfactuals.empty());
  }
}

TEST_CASE("A policy with a memory follows its past, in its own scene and in another's", "[probe]") {
  const Json document =
      probe_external(settings_for({kShell}, 12), true, {.probes = {Probe::kTwins}});
  const Json& twins = section(document, "twins");
  CHECK(rate(twins, "follow") == 1);
  CHECK(rate(twins, "both_follow") == 1);
  CHECK(rate(part(twins, "swapped"), "past") == 1);
  CHECK(rate(part(twins, "swapped"), "scene") == 0);
  CHECK(rate(twins, "stay") == 1);
  // Wiped at the question it is left with the middle cup.
  const double chance = number(part(twins, "chance"));
  CHECK(rate(twins, "wiped_follow") < chance + 0.3);
  CHECK(number(list(part(part(twins, "wiped_follow"), "interval")).at(0)) <= chance);
}

TEST_CASE("Policies without a memory follow by chance, and never both pasts", "[probe]") {
  const EvaluationSettings settings = settings_for({kShell}, 24);
  const Json blind = probe(settings, Policy::kBlind, {.probes = {Probe::kTwins}});
  const Json forgetful = probe_external(settings, false, {.probes = {Probe::kTwins}});
  for (const Json* document : {&blind, &forgetful}) {
    const Json& twins = section(*document, "twins");
    CHECK(rate(twins, "both_follow") == 0);
    const JsonList& interval = list(part(part(twins, "follow"), "interval"));
    CHECK(number(interval.at(0)) <= number(part(twins, "chance")));
    CHECK(number(interval.at(1)) >= number(part(twins, "chance")) / 2);
  }
}

// Rests, in chunks that would last for the whole episode, and counts the requests of each trial.
class RestingPolicy final : public ExternalPolicy {
 public:
  explicit RestingPolicy(std::map<std::int32_t, int>& requests) : requests_(requests) {}

  void act(const PolicyRequest& request, PolicyReply& reply) override {
    const std::vector<float> chunk(7 * 1000);
    const std::int64_t shape[] = {1000, 7};
    for (int row = 0; row < request.count; ++row) {
      ++requests_[request.numbers[static_cast<std::size_t>(row)]];
      reply.set(row, chunk, shape);
    }
  }

 private:
  std::map<std::int32_t, int>& requests_;
};

TEST_CASE("Actions that are queued during the cue are dropped at the question", "[probe]") {
  const EvaluationSettings settings = settings_for({kShell}, 2);
  std::map<std::int32_t, int> requests;
  Protocol protocol = protocol_of(settings);
  protocol.external = [&](const WorkContext& /*context*/) {
    return std::make_unique<RestingPolicy>(requests);
  };
  protocol.threads = 1;
  (void)run_probes(settings, protocol, {.probes = {Probe::kTwins}}, {});
  // The numbers are those of trials, and each trial asks as it begins and at the question.
  CHECK(requests.size() >= 12);
  for (const auto& [number, count] : requests) CHECK(count == 2);
}

TEST_CASE("Modes that the oracle of a probe cannot act in are refused before anything is played",
          "[probe]") {
  EvaluationSettings settings = settings_for({"GatherAndRecall1-VLA-v0"}, 1);
  settings.control_mode = ControlMode::kPdEeDeltaPos;
  Protocol protocol = protocol_of(settings);
  int made = 0;
  protocol.external = [&made](const WorkContext& /*context*/) {
    ++made;
    return std::make_unique<test::RememberingPolicy>(true);
  };
  CHECK_THROWS_WITH(run_probes(settings, protocol, {.probes = {Probe::kTwins}}, {}),
                    Catch::Contains("GatherAndRecall1-VLA-v0") &&
                        Catch::Contains("pd_ee_delta_pos") &&
                        Catch::Contains("pd_ee_delta_pose, pd_joint_pos"));
  CHECK(made == 0);
}

TEST_CASE("Policies that name answers are refused, and constants that the other task lacks",
          "[probe]") {
  EvaluationSettings settings = settings_for({kShell}, 1);
  settings.choices = true;
  CHECK_THROWS_WITH(probe(settings, Policy::kOracle, {}), Catch::Contains("choices"));
  settings.choices = false;
  settings.constants = {{"BALL_RADIUS", 0.02}};
  const ProbeOptions options{.probes = {Probe::kInterference}, .other = "RememberColor3-VLA-v0"};
  CHECK_THROWS(probe(settings, Policy::kOracle, options));
}

// --- forgetting, interference, capacity ---

TEST_CASE("A memory that time does not change does not forget", "[probe]") {
  const ProbeOptions options{.probes = {Probe::kForgetting}};
  const EvaluationSettings settings = settings_for({kShell}, 8);
  const Json kept = probe_external(settings, true, options);
  const Json lost = probe_external(settings, false, options);
  const Json& curve = section(kept, "forgetting");
  for (std::size_t i = 0; i < list(part(curve, "points")).size(); ++i) {
    CHECK(rate(point(curve, i), "first_answer") == 1);
  }
  CHECK(is_null(part(part(curve, "half_length"), "steps")));
  CHECK(rate(point(section(lost, "forgetting"), 0), "first_answer") < 1);
}

TEST_CASE("Delays reach ten times those of the task", "[probe]") {
  const Json document = probe(settings_for({"RememberColor3-VLA-v0"}, 1), Policy::kOracle,
                              {.probes = {Probe::kForgetting}});
  const Json& curve = section(document, "forgetting");
  std::vector<double> delays;
  for (const Json& one : list(part(curve, "points"))) {
    delays.push_back(number(part(one, "delay")));
    CHECK(rate(one, "success") == 1);
  }
  CHECK(delays == std::vector<double>{1, 5, 10, 25, 50});
  CHECK(text(part(curve, "constant")) == "EMPTY_PHASE_STEPS");
}

TEST_CASE("A memory of the last cue is overwritten by competing episodes alone", "[probe]") {
  const Json document =
      probe_external(settings_for({kShell}, 10), true, {.probes = {Probe::kInterference}});
  const Json& section_of = section(document, "interference");
  for (const Json& one : list(part(section_of, "points"))) {
    INFO(to_line(one));
    const bool competing = text(part(one, "kind")) == "competing";
    CHECK(rate(one, "first_answer") == (competing ? 0 : 1));
    if (competing) CHECK(rate(one, "intrusions") == 1);
  }
}

TEST_CASE("Episodes of another task go between, too", "[probe]") {
  const ProbeOptions options{.probes = {Probe::kInterference}, .other = "ShellGamePush-VLA-v0"};
  const Json document = probe(settings_for({kShell}, 2), Policy::kOracle, options);
  int others = 0;
  for (const Json& one : list(part(section(document, "interference"), "points"))) {
    others += text(part(one, "kind")) == "other task" ? 1 : 0;
    CHECK(rate(one, "success") == 1);
  }
  CHECK(others == 3);
}

TEST_CASE("Capacity has the oracle beside the policy", "[probe]") {
  const Json document = probe(settings_for({"BlinkCountButtonPressEasy-VLA-v0"}, 2), Policy::kBlind,
                              {.probes = {Probe::kCapacity}});
  const Json& capacity = section(document, "capacity");
  CHECK(text(part(capacity, "quantity")) == "target_blinks");
  std::vector<double> items;
  for (const Json& one : list(part(capacity, "points"))) {
    items.push_back(number(part(one, "items")));
    CHECK(rate(part(one, "oracle"), "success") == 1);
  }
  CHECK(items == std::vector<double>{1, 2, 3});
}

TEST_CASE("Numbers of items that a policy cannot observe are left out, with the reason",
          "[probe]") {
  const Json document = probe_external(settings_for({"RememberColor3-VLA-v0"}, 1), true,
                                       {.probes = {Probe::kCapacity}});
  for (const Json& one : list(part(section(document, "capacity"), "points"))) {
    const bool own = number(part(one, "items")) == 3;
    CHECK((find(one, "skipped") == nullptr) == own);
  }
}

TEST_CASE("Families whose observation keeps its size have points for every number of items",
          "[probe]") {
  const std::map<std::string, std::vector<double>> items = {
      {"SeqOfColors3-VLA-v0", {1, 3, 5, 7}},  // all nine have one answer
      {"ShellGameShuffleTouch-VLA-v0", {2, 3, 4}},
      {"BlinkCountButtonPressEasy-VLA-v0", {1, 2, 3}}};
  for (const auto& [id, expected] : items) {
    INFO(id);
    Protocol protocol = protocol_of(settings_for({id}, 1));
    std::map<std::int32_t, int> requests;
    protocol.external = [&requests](const WorkContext& /*context*/) {
      return std::make_unique<RestingPolicy>(requests);
    };
    protocol.threads = 1;
    const Json document =
        run_probes(settings_for({id}, 1), protocol, {.probes = {Probe::kCapacity}}, {});
    std::vector<double> played;
    for (const Json& one : list(part(section(document, "capacity"), "points"))) {
      if (find(one, "skipped") == nullptr) played.push_back(number(part(one, "items")));
    }
    CHECK(played == expected);
  }
}

// --- as a whole ---

TEST_CASE("Probes do not depend on threads and batch size", "[probe]") {
  const EvaluationSettings settings = settings_for({kShell}, 5);
  const std::string one = to_text(probe_external(settings, true, {}, 1, 1));
  CHECK(to_text(probe_external(settings, true, {}, 3, 2)) == one);
  CHECK(to_text(probe_external(settings, true, {}, 2, 8)) == one);
}

TEST_CASE("Reports of probes have a curve for each of them", "[probe]") {
  const Json document = probe_external(
      settings_for({kShell, "BlinkCountButtonPressEasy-VLA-v0", "InterceptFast-VLA-v0"}, 1), false,
      {});
  const std::string page = probe_report(document);
  for (const char* heading : {"Twins", "Forgetting", "Interference", "Capacity", "Not probed"}) {
    CHECK_THAT(page, Catch::Contains(std::string("<h2>") + heading + "</h2>"));
  }
  CHECK_THAT(page, Catch::Contains("<polyline points=") && Catch::Contains("nothing is hidden"));
}

TEST_CASE("Lists of probes are read, and wrong ones refused", "[probe]") {
  CHECK(parse_probes("--probes", "capacity,twins") ==
        std::vector<Probe>{Probe::kTwins, Probe::kCapacity});
  for (const char* text : {"", "twin", "twins,", "twins,twins"}) {
    INFO(text);
    CHECK_THROWS_WITH(parse_probes("--probes", text),
                      Catch::Contains("twins, forgetting, interference, capacity"));
  }
}

TEST_CASE("Settings that probes do not have are refused", "[probe]") {
  EvaluationSettings settings = settings_for({kShell}, 1);
  settings.repeat = 2;
  CHECK_THROWS_WITH(probe(settings, Policy::kOracle, {}), Catch::Contains("repeat: 2 given"));
  settings.repeat = 1;
  Protocol protocol = protocol_of(settings);
  protocol.external = [](const WorkContext& /*context*/) {
    return std::make_unique<test::RememberingPolicy>(true);
  };
  CHECK_THROWS_WITH(run_probes(settings, protocol, {.other = "RememberColor9-VLA-v0"}, {}),
                    Catch::Contains("RememberColor9-VLA-v0"));
}

}  // namespace
}  // namespace engram
