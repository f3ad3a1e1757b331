// Which tasks have choices.
#include "protocol/eval/run/choice_tasks.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

TEST_CASE("Tasks without choices are refused by name", "[choices]") {
  const auto refused = [](const std::string& id, const auto& change) {
    EvaluationSettings settings;
    settings.tasks = {id};
    change(settings);
    std::string message;
    try {
      require_choices(settings);
    } catch (const Error& error) {
      message = error.what();
    }
    return message;
  };
  const auto as_they_are = [](EvaluationSettings& /*settings*/) {};
  CHECK(refused("RememberColor3-VLA-v0", as_they_are).empty());
  for (const char* id : {"TimedTransferEasy-VLA-v0", "RotateLenientPos-VLA-v0",
                         "InterceptSlow-VLA-v0", "TraceShapeEasy-VLA-v0"}) {
    const std::string message = refused(id, as_they_are);
    CHECK_THAT(message, Catch::StartsWith(std::string(id) + " has no list of answers"));
    CHECK_THAT(message, Catch::Contains("RememberColor, ") && Catch::Contains("TraceShapeHard"));
    CHECK_THAT(message, !Catch::Contains("Rotate,") && !Catch::Contains("Intercept,"));
  }
  CHECK_THAT(refused("RememberColor3-VLA-v0", [](EvaluationSettings& all) { all.latency = 2; }),
             Catch::Contains("a latency of 2 steps given, 0 allowed"));
  CHECK_THAT(
      refused("RememberColor3-VLA-v0",
              [](EvaluationSettings& all) { all.control_mode = ControlMode::kPdJointDeltaPos; }),
      Catch::Equals(""));
  CHECK_THAT(
      refused("RememberShapeAndColor3x2-VLA-v0",
              [](EvaluationSettings& all) {
                all.constants = {
                    {"COLOR_PALETTE", ConstantList{"red", ConstantList{0.95, 0.05, 0.0}, "blue"}}};
              }),
      Catch::Contains("two answers are 'the red "));
  // Nothing to choose from once there is one shape.
  CHECK_THAT(refused("TraceShapeHard-VLA-v0",
                     [](EvaluationSettings& all) {
                       all.constants = {{"AVAILABLE_SHAPES", ConstantList{"circle"}}};
                     }),
             Catch::Contains("no list of answers"));
}

}  // namespace
}  // namespace engram
