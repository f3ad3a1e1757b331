#include "tasks/registry_table.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <vector>

namespace engram {
namespace {

struct Family {
  std::string_view name;
  std::string_view memory_type;
  std::string_view instruction;
};

// clang-format off
constexpr Family kShellGameTouch = {"ShellGameTouch", "Spatial",
    "Observe which cup hides the ball, wait, then touch that cup."};
constexpr Family kShellGamePush = {"ShellGamePush", "Spatial",
    "Observe which cup hides the ball, wait, then push that cup forward."};
constexpr Family kShellGamePick = {"ShellGamePick", "Spatial",
    "Observe which cup hides the ball, wait, then pick up that cup and lift it."};
constexpr Family kShellGameColorLampTouch = {"ShellGameColorLampTouch", "Spatial",
    "Observe which color is under each cup, then touch the cup matching the lamp color."};
constexpr Family kShuffleTouch = {"ShellGameShuffleTouch", "Tracking",
    "Observe which cup hides the ball, track the cups as they shuffle, then touch the correct "
    "cup."};
constexpr Family kShuffleColorLampTouch = {"ShellGameShuffleColorLampTouch", "Tracking",
    "Observe which color is under each cup, track the cups as they shuffle, then touch the cup "
    "matching the lamp color."};
constexpr Family kRememberColor = {"RememberColor", "Object",
    "Observe the cube's color, wait, then touch the cube of the same color."};
constexpr Family kRememberShape = {"RememberShape", "Object",
    "Observe the object's shape, wait, then touch the object of the same shape."};
constexpr Family kRememberShapeAndColor = {"RememberShapeAndColor", "Object",
    "Observe the object's shape and color, wait, then touch the object of the same shape and "
    "color."};
constexpr Family kFindImposterColor = {"FindImposterColor", "Negative",
    "Observe the cubes shown, wait, then touch the cube whose color was not present before."};
constexpr Family kFindImposterShape = {"FindImposterShape", "Negative",
    "Observe the shapes shown, wait, then touch the object whose shape was not present before."};
constexpr Family kFindImposterShapeAndColor = {"FindImposterShapeAndColor", "Negative",
    "Observe the objects shown, wait, then touch the object whose shape and color combination "
    "was not present before."};
constexpr Family kSeqOfColors = {"SeqOfColors", "Capacity",
    "Observe which colored cubes appear during the cue, wait, then touch all of them in any "
    "order and press the center button."};
constexpr Family kChainOfColors = {"ChainOfColors", "Sequential",
    "Observe which colored cubes appear during the cue, wait, then touch all of them in the "
    "same order as the cubes were shown and press the center button."};
constexpr Family kBunchOfColors = {"BunchOfColors", "Capacity",
    "Observe which colored cubes appear during the cue, wait, then touch all of them in any "
    "order and press the center button."};
constexpr Family kIntercept = {"Intercept", "Spatial",
    "Intercept the rolling ball by moving to its path and deflecting it toward the target."};
constexpr Family kInterceptGrab = {"InterceptGrab", "Spatial",
    "Intercept the rolling ball and grasp it to stop it."};
constexpr Family kRotateLenient = {"RotateLenient", "Spatial",
    "Rotate the peg by {angle_deg} degrees to match the target angle."};
constexpr Family kRotateStrict = {"RotateStrict", "Spatial",
    "Rotate the peg by {angle_deg} degrees to match the target angle while keeping the center "
    "of the peg in place."};
constexpr Family kTraceShape = {"TraceShape", "Procedural",
    "Watch the red cube trace a shape on the table. When the lamp turns green, pick up the "
    "green cube and trace exactly the same shape."};
constexpr Family kTraceShapeSeq = {"TraceShapeSeq", "Procedural",
    "Watch the red cube trace a sequence of shapes. When the lamp turns green, pick up the "
    "green cube and trace the same sequence in order. After finishing all shapes, press the "
    "button to submit your answer."};
constexpr Family kBatteriesCheckerEasy = {"BatteriesCheckerEasy", "Checklist",
    "Find all working batteries by inserting each one into the socket, observing the lamp "
    "result, and then pressing the button to confirm."};
constexpr Family kBatteriesCheckerHard = {"BatteriesCheckerHard", "Checklist",
    "Find all working batteries by inserting each one into the socket, observing the lamp "
    "result, returning it from the socket to its initial slot, and then pressing the button to "
    "confirm."};
constexpr Family kTakeItBack = {"TakeItBack", "Spatial",
    "Push the cube onto the red target, and when the target changes color, return the cube to "
    "its original position."};
constexpr Family kGatherAndRecall = {"GatherAndRecall", "Prospective",
    "Move all cubes onto the disc. A lamp will briefly flash while you work. After all cubes "
    "are placed, press the button matching the flash color."};
constexpr Family kTimedTransfer100 = {"TimedTransfer", "Temporal",
    "When the white lamp turns green, start counting steps from that exact moment. Move the "
    "blue cube from the green disc to the red disc exactly on step 100 of that count."};
constexpr Family kTimedTransfer150 = {"TimedTransfer", "Temporal",
    "When the white lamp turns green, start counting steps from that exact moment. Move the "
    "blue cube from the green disc to the red disc exactly on step 150 of that count."};
constexpr Family kTimedTransfer200 = {"TimedTransfer", "Temporal",
    "When the white lamp turns green, start counting steps from that exact moment. Move the "
    "blue cube from the green disc to the red disc exactly on step 200 of that count."};
constexpr Family kTimedTransfer300 = {"TimedTransfer", "Temporal",
    "When the white lamp turns green, start counting steps from that exact moment. Move the "
    "blue cube from the green disc to the red disc exactly on step 300 of that count."};
constexpr Family kTimedTransfer500 = {"TimedTransfer", "Temporal",
    "When the white lamp turns green, start counting steps from that exact moment. Move the "
    "blue cube from the green disc to the red disc exactly on step 500 of that count."};
constexpr Family kTimedTransfer1000 = {"TimedTransfer", "Temporal",
    "When the white lamp turns green, start counting steps from that exact moment. Move the "
    "blue cube from the green disc to the red disc exactly on step 1000 of that count."};
constexpr Family kBlinkCountButtonPress = {"BlinkCountButtonPress", "Temporal",
    "Count how many times the blue lamp blinks, press the red button exactly that many times "
    "when the red lamp turns green, then press the black button to submit your answer."};
// clang-format on

constexpr RegistryEntry row(std::string_view id, int horizon, Split split, const Family& family) {
  return {.id = id,
          .family = family.name,
          .horizon = horizon,
          .split = split,
          .memory_type = family.memory_type,
          .canonical = split != Split::kExtended,
          .instruction = family.instruction};
}

using enum Split;

// clang-format off
constexpr RegistryEntry kRegistry[] = {
    row("ShellGameTouch-VLA-v0",                        30, kShort,    kShellGameTouch),
    row("ShellGamePush-VLA-v0",                         30, kShort,    kShellGamePush),
    row("ShellGamePick-VLA-v0",                         30, kExtended, kShellGamePick),
    row("ShellGameColorLampTouch-VLA-v0",               30, kShort,    kShellGameColorLampTouch),
    row("ShellGameShuffleTouch-Long-VLA-v0",           600, kMedium,   kShuffleTouch),
    row("ShellGameShuffleTouch-VLA-v0",                 60, kShort,    kShuffleTouch),
    row("ShellGameShuffleColorLampTouch-Long-VLA-v0",  600, kMedium,   kShuffleColorLampTouch),
    row("ShellGameShuffleColorLampTouch-VLA-v0",        60, kShort,    kShuffleColorLampTouch),

    row("RememberColor3-Long-VLA-v0",                  600, kMedium,   kRememberColor),
    row("RememberColor3-VLA-v0",                        25, kShort,    kRememberColor),
    row("RememberColor5-Long-VLA-v0",                  600, kMedium,   kRememberColor),
    row("RememberColor5-VLA-v0",                        25, kShort,    kRememberColor),
    row("RememberColor9-Long-VLA-v0",                  600, kMedium,   kRememberColor),
    row("RememberColor9-VLA-v0",                        25, kShort,    kRememberColor),

    row("RememberShape3-Long-VLA-v0",                  600, kMedium,   kRememberShape),
    row("RememberShape3-VLA-v0",                        25, kShort,    kRememberShape),
    row("RememberShape5-Long-VLA-v0",                  600, kMedium,   kRememberShape),
    row("RememberShape5-VLA-v0",                        25, kShort,    kRememberShape),
    row("RememberShape9-Long-VLA-v0",                  600, kMedium,   kRememberShape),
    row("RememberShape9-VLA-v0",                        25, kShort,    kRememberShape),

    row("RememberShapeAndColor3x2-Long-VLA-v0",        600, kMedium,   kRememberShapeAndColor),
    row("RememberShapeAndColor3x2-VLA-v0",              25, kShort,    kRememberShapeAndColor),
    row("RememberShapeAndColor3x3-Long-VLA-v0",        600, kMedium,   kRememberShapeAndColor),
    row("RememberShapeAndColor3x3-VLA-v0",              25, kShort,    kRememberShapeAndColor),
    row("RememberShapeAndColor5x3-Long-VLA-v0",        600, kMedium,   kRememberShapeAndColor),
    row("RememberShapeAndColor5x3-VLA-v0",              25, kShort,    kRememberShapeAndColor),

    row("FindImposterColor3-VLA-v0",                    25, kShort,    kFindImposterColor),
    row("FindImposterColor5-VLA-v0",                    25, kShort,    kFindImposterColor),
    row("FindImposterColor9-VLA-v0",                    25, kShort,    kFindImposterColor),

    row("FindImposterShape3-VLA-v0",                    25, kShort,    kFindImposterShape),
    row("FindImposterShape5-VLA-v0",                    25, kShort,    kFindImposterShape),
    row("FindImposterShape9-VLA-v0",                    25, kShort,    kFindImposterShape),

    row("FindImposterShapeAndColor3x2-VLA-v0",          25, kShort,    kFindImposterShapeAndColor),
    row("FindImposterShapeAndColor3x3-VLA-v0",          25, kShort,    kFindImposterShapeAndColor),
    row("FindImposterShapeAndColor5x3-VLA-v0",          40, kShort,    kFindImposterShapeAndColor),

    row("SeqOfColors3-Long-VLA-v0",                    800, kLong,     kSeqOfColors),
    row("SeqOfColors3-VLA-v0",                         400, kMedium,   kSeqOfColors),
    row("SeqOfColors5-Long-VLA-v0",                   1000, kLong,     kSeqOfColors),
    row("SeqOfColors5-VLA-v0",                         400, kMedium,   kSeqOfColors),
    row("SeqOfColors7-Long-VLA-v0",                   1200, kLong,     kSeqOfColors),
    row("SeqOfColors7-VLA-v0",                         400, kMedium,   kSeqOfColors),

    row("ChainOfColors3-Long-VLA-v0",                  800, kLong,     kChainOfColors),
    row("ChainOfColors3-VLA-v0",                       400, kMedium,   kChainOfColors),
    row("ChainOfColors5-Long-VLA-v0",                 1000, kLong,     kChainOfColors),
    row("ChainOfColors5-VLA-v0",                       400, kMedium,   kChainOfColors),
    row("ChainOfColors7-Long-VLA-v0",                 1200, kLong,     kChainOfColors),
    row("ChainOfColors7-VLA-v0",                       400, kMedium,   kChainOfColors),

    row("BunchOfColors3-Long-VLA-v0",                  700, kLong,     kBunchOfColors),
    row("BunchOfColors3-VLA-v0",                       400, kMedium,   kBunchOfColors),
    row("BunchOfColors5-Long-VLA-v0",                  700, kLong,     kBunchOfColors),
    row("BunchOfColors5-VLA-v0",                       400, kMedium,   kBunchOfColors),
    row("BunchOfColors7-Long-VLA-v0",                  700, kLong,     kBunchOfColors),
    row("BunchOfColors7-VLA-v0",                       400, kMedium,   kBunchOfColors),

    row("InterceptFast-VLA-v0",                         60, kShort,    kIntercept),
    row("InterceptMedium-VLA-v0",                       60, kShort,    kIntercept),
    row("InterceptSlow-VLA-v0",                         60, kShort,    kIntercept),

    row("InterceptGrabFast-VLA-v0",                     60, kShort,    kInterceptGrab),
    row("InterceptGrabMedium-VLA-v0",                   60, kShort,    kInterceptGrab),
    row("InterceptGrabSlow-VLA-v0",                     60, kShort,    kInterceptGrab),

    row("RotateLenientPosNeg-VLA-v0",                   60, kShort,    kRotateLenient),
    row("RotateLenientPos-VLA-v0",                      60, kShort,    kRotateLenient),

    row("RotateStrictPosNeg-VLA-v0",                    90, kShort,    kRotateStrict),
    row("RotateStrictPos-VLA-v0",                       90, kShort,    kRotateStrict),

    row("TraceShapeEasy-VLA-v0",                       250, kMedium,   kTraceShape),
    row("TraceShapeHard-VLA-v0",                       350, kMedium,   kTraceShape),
    row("TraceShapeMedium-VLA-v0",                     300, kMedium,   kTraceShape),

    row("TraceShapeSeqEasy-VLA-v0",                   1500, kLong,     kTraceShapeSeq),
    row("TraceShapeSeqHard-VLA-v0",                   1500, kLong,     kTraceShapeSeq),
    row("TraceShapeSeqMedium-VLA-v0",                 1500, kLong,     kTraceShapeSeq),

    row("BatteriesCheckerEasy-12-VLA-v0",             2160, kExtended, kBatteriesCheckerEasy),
    row("BatteriesCheckerEasy-15-VLA-v0",             2400, kExtended, kBatteriesCheckerEasy),
    row("BatteriesCheckerEasy-3-VLA-v0",               540, kMedium,   kBatteriesCheckerEasy),
    row("BatteriesCheckerEasy-6-VLA-v0",              1080, kLong,     kBatteriesCheckerEasy),
    row("BatteriesCheckerEasy-9-VLA-v0",              1620, kExtended, kBatteriesCheckerEasy),

    row("BatteriesCheckerHard-12-VLA-v0",             4320, kExtended, kBatteriesCheckerHard),
    row("BatteriesCheckerHard-15-VLA-v0",             4320, kExtended, kBatteriesCheckerHard),
    row("BatteriesCheckerHard-3-VLA-v0",              1080, kLong,     kBatteriesCheckerHard),
    row("BatteriesCheckerHard-6-VLA-v0",              2160, kLong,     kBatteriesCheckerHard),
    row("BatteriesCheckerHard-9-VLA-v0",              3240, kExtended, kBatteriesCheckerHard),

    row("TakeItBack-VLA-v0",                            60, kShort,    kTakeItBack),

    row("GatherAndRecall1-VLA-v0",                     200, kShort,    kGatherAndRecall),
    row("GatherAndRecall3-VLA-v0",                     400, kMedium,   kGatherAndRecall),
    row("GatherAndRecall5-VLA-v0",                     600, kMedium,   kGatherAndRecall),
    row("GatherAndRecall7-VLA-v0",                     800, kLong,     kGatherAndRecall),
    row("GatherAndRecall9-VLA-v0",                    1000, kLong,     kGatherAndRecall),

    row("TimedTransferEasy-Long-VLA-v0",               600, kMedium,   kTimedTransfer300),
    row("TimedTransferEasy-VLA-v0",                    200, kShort,    kTimedTransfer100),
    row("TimedTransferHard-Long-VLA-v0",              1200, kLong,     kTimedTransfer1000),
    row("TimedTransferHard-VLA-v0",                    300, kMedium,   kTimedTransfer200),
    row("TimedTransferMedium-Long-VLA-v0",             900, kLong,     kTimedTransfer500),
    row("TimedTransferMedium-VLA-v0",                  250, kMedium,   kTimedTransfer150),

    row("BlinkCountButtonPressEasy-VLA-v0",            150, kShort,    kBlinkCountButtonPress),
    row("BlinkCountButtonPressEasy-Long-VLA-v0",      1200, kLong,     kBlinkCountButtonPress),
    row("BlinkCountButtonPressMedium-VLA-v0",          200, kShort,    kBlinkCountButtonPress),
    row("BlinkCountButtonPressMedium-Long-VLA-v0",    1200, kLong,     kBlinkCountButtonPress),
    row("BlinkCountButtonPressHard-VLA-v0",            300, kMedium,   kBlinkCountButtonPress),
    row("BlinkCountButtonPressHard-Long-VLA-v0",      1200, kLong,     kBlinkCountButtonPress),
};
// clang-format on

char to_lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

// Number of characters to insert, delete or replace to turn `a` into `b`, case being ignored.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  // row[j]: distance between the part of `a` read so far and the first j characters of `b`.
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (to_lower(a[i]) == to_lower(b[j]) ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, diagonal + 1, row[j] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::span<const RegistryEntry> registry() noexcept { return kRegistry; }

const RegistryEntry* find_entry(std::string_view id) noexcept {
  const auto found = std::ranges::find(kRegistry, id, &RegistryEntry::id);
  return found == std::end(kRegistry) ? nullptr : found;
}

std::string nearest_id(std::string_view id) {
  // No id is nearly this long: what follows tells nothing and would only cost time.
  id = id.substr(0, 100);
  const auto distance = [id](const RegistryEntry& entry) { return edit_distance(id, entry.id); };
  return std::string(std::ranges::min_element(kRegistry, {}, distance)->id);
}

std::string_view split_name(Split split) noexcept {
  switch (split) {
    case kShort:
      return "short";
    case kMedium:
      return "medium";
    case kLong:
      return "long";
    case kExtended:
      return "extended";
  }
  return "";
}

}  // namespace engram
