// The objects observation in words.
#include "protocol/eval/policies/object_text.h"

#include <catch2/catch.hpp>

#include "core/batch/scripted_policy.h"
#include "protocol/make/make.h"
#include "protocol/make/rows.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

std::unique_ptr<Batch> observed(const std::string& id, const std::vector<Pin>& pins = {}) {
  MakeOptions options;
  options.obs_mode = ObsMode::kObjects;
  options.threads = 1;
  options.auto_reset = AutoReset::kOff;
  options.pins = pins;
  std::unique_ptr<Batch> batch = make(id, options);
  batch->reset();
  return batch;
}

std::string text_of(const Batch& batch) {
  return ObjectText(batch).describe(row_of(batch.outputs().observation, batch, 0));
}

TEST_CASE("Objects have their names and places in words", "[objects]") {
  const auto batch = observed("RememberColor3-VLA-v0", {{"target", {2}}});
  const std::string text = text_of(*batch);
  CHECK_THAT(text, Catch::StartsWith("hand at x "));
  CHECK_THAT(text, Catch::Contains(" % open; blue cube at x "));
  CHECK_THAT(text, Catch::EndsWith("; 2 objects hidden"));
  CHECK_THAT(text, !Catch::Contains("red") && !Catch::Contains("green"));
}

TEST_CASE("What is hidden has no name", "[objects]") {
  const auto batch = observed("RememberColor3-VLA-v0");
  int hidden = 0;
  for (int step = 0; step < 20; ++step) {
    test::step(*batch, Policy::kZero);
    const std::string text = text_of(*batch);
    if (text.find("3 objects hidden") == std::string::npos) continue;
    CHECK_THAT(text, !Catch::Contains("cube"));
    ++hidden;
  }
  CHECK(hidden > 0);
}

TEST_CASE("Words follow from the row alone", "[objects]") {
  const auto batch = observed("ShellGameTouch-VLA-v0");
  const ObjectText words(*batch);
  std::vector<float> row(batch->outputs().observation.begin(), batch->outputs().observation.end());
  const std::string text = words.describe(row);
  test::step(*batch, Policy::kOracle);
  test::step(*batch, Policy::kOracle);
  CHECK(words.describe(row) == text);
  std::fill(row.begin() + 25, row.end(), 0.0F);
  CHECK_THAT(words.describe(row),
             Catch::EndsWith("5 objects hidden") || Catch::EndsWith("4 objects hidden"));
}

TEST_CASE("Lamps are lit or off, and buttons are pressed", "[objects]") {
  const auto batch = observed("BlinkCountButtonPressEasy-VLA-v0");
  std::string all;
  for (int step = 0; step < 60; ++step) {
    test::step(*batch, Policy::kOracle);
    all += text_of(*batch) + "\n";
  }
  CHECK_THAT(all, Catch::Contains("lamp at x ") && Catch::Contains(", lit"));
  CHECK_THAT(all, Catch::Contains(", off"));
  CHECK_THAT(all, Catch::Contains("red button at x ") && Catch::Contains(", pressed "));
}

}  // namespace
}  // namespace engram
