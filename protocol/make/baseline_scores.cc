#include "protocol/make/baseline_scores.h"

#include <algorithm>
#include <span>

namespace engram {
namespace {

constexpr BaselineScores kBaselineScores[] = {
    // begin vla: written by tools/measure.py memory
    {"ShellGameTouch-VLA-v0", 0.295, 1, 1, 0.295, 0.385, 1},
    {"ShellGamePush-VLA-v0", 0.33, 0.98, 1, 0.33, 0.315, 1},
    {"ShellGamePick-VLA-v0", 0.345, 0.37, 0.995, 0.345, 0.37, 1},
    {"ShellGameColorLampTouch-VLA-v0", 0.38, 1, 1, 0.38, 0.37, 1},
    {"ShellGameShuffleTouch-Long-VLA-v0", 0.27, 1, 1, 0.27, 0.3, 1},
    {"ShellGameShuffleTouch-VLA-v0", 0.29, 0.995, 1, 0.29, 0.335, 1},
    {"ShellGameShuffleColorLampTouch-Long-VLA-v0", 0.375, 1, 1, 0.375, 0.355, 1},
    {"ShellGameShuffleColorLampTouch-VLA-v0", 0.335, 0.995, 1, 0.335, 0.3, 1},
    {"RememberColor3-Long-VLA-v0", 0.265, 1, 1, 0.265, 0.34, 1},
    {"RememberColor3-VLA-v0", 0.375, 0.615, 1, 0.375, 0.31, 1},
    {"RememberColor5-Long-VLA-v0", 0.215, 0.985, 1, 0.215, 0.21, 1},
    {"RememberColor5-VLA-v0", 0.225, 0.6, 0.995, 0.225, 0.24, 0.995},
    {"RememberColor9-Long-VLA-v0", 0.125, 0.99, 1, 0.125, 0.12, 1},
    {"RememberColor9-VLA-v0", 0.15, 0.425, 1, 0.15, 0.13, 1},
    {"RememberShape3-Long-VLA-v0", 0.31, 1, 1, 0.31, 0.315, 1},
    {"RememberShape3-VLA-v0", 0.355, 0.68, 1, 0.355, 0.335, 1},
    {"RememberShape5-Long-VLA-v0", 0.2, 0.98, 1, 0.2, 0.18, 1},
    {"RememberShape5-VLA-v0", 0.2, 0.55, 1, 0.2, 0.185, 1},
    {"RememberShape9-Long-VLA-v0", 0.065, 0.995, 1, 0.065, 0.11, 1},
    {"RememberShape9-VLA-v0", 0.16, 0.32, 1, 0.16, 0.09, 1},
    {"RememberShapeAndColor3x2-Long-VLA-v0", 0.125, 0.995, 1, 0.125, 0.195, 1},
    {"RememberShapeAndColor3x2-VLA-v0", 0.15, 0.49, 1, 0.15, 0.14, 1},
    {"RememberShapeAndColor3x3-Long-VLA-v0", 0.13, 0.985, 1, 0.13, 0.085, 1},
    {"RememberShapeAndColor3x3-VLA-v0", 0.095, 0.305, 1, 0.095, 0.08, 1},
    {"RememberShapeAndColor5x3-Long-VLA-v0", 0.095, 0.965, 1, 0.095, 0.045, 1},
    {"RememberShapeAndColor5x3-VLA-v0", 0.085, 0.225, 1, 0.08, 0.04, 1},
    {"FindImposterColor3-VLA-v0", 0.405, 0.985, 1, 0.405, 0.28, 1},
    {"FindImposterColor5-VLA-v0", 0.225, 0.64, 1, 0.225, 0.195, 1},
    {"FindImposterColor9-VLA-v0", 0.135, 0.575, 1, 0.135, 0.13, 1},
    {"FindImposterShape3-VLA-v0", 0.32, 1, 1, 0.32, 0.325, 1},
    {"FindImposterShape5-VLA-v0", 0.26, 0.6, 1, 0.26, 0.17, 1},
    {"FindImposterShape9-VLA-v0", 0.085, 0.57, 1, 0.085, 0.135, 1},
    {"FindImposterShapeAndColor3x2-VLA-v0", 0.195, 0.64, 1, 0.195, 0.21, 1},
    {"FindImposterShapeAndColor3x3-VLA-v0", 0.135, 0.575, 1, 0.135, 0.135, 1},
    {"FindImposterShapeAndColor5x3-VLA-v0", 0.065, 0.485, 1, 0.065, 0.065, 1},
    {"SeqOfColors3-Long-VLA-v0", 0.01, 0.025, 1, 0.01, 0.025, 1},
    {"SeqOfColors3-VLA-v0", 0.01, 0.01, 1, 0.01, 0.01, 1},
    {"SeqOfColors5-Long-VLA-v0", 0.025, 0.015, 1, 0.025, 0.015, 1},
    {"SeqOfColors5-VLA-v0", 0.005, 0.005, 1, 0.005, 0.005, 1},
    {"SeqOfColors7-Long-VLA-v0", 0.055, 0.025, 1, 0.055, 0.025, 1},
    {"SeqOfColors7-VLA-v0", 0.05, 0.025, 1, 0.05, 0.025, 1},
    {"ChainOfColors3-Long-VLA-v0", 0, 0, 1, 0, 0, 1},
    {"ChainOfColors3-VLA-v0", 0.005, 0.005, 1, 0.005, 0.005, 1},
    {"ChainOfColors5-Long-VLA-v0", 0, 0, 1, 0, 0, 1},
    {"ChainOfColors5-VLA-v0", 0, 0, 1, 0, 0, 1},
    {"ChainOfColors7-Long-VLA-v0", 0, 0, 1, 0, 0, 1},
    {"ChainOfColors7-VLA-v0", 0, 0, 1, 0, 0, 1},
    {"BunchOfColors3-Long-VLA-v0", 0.02, 0.025, 1, 0.02, 0.025, 1},
    {"BunchOfColors3-VLA-v0", 0.005, 0.01, 1, 0.005, 0.01, 1},
    {"BunchOfColors5-Long-VLA-v0", 0.025, 0.02, 1, 0.025, 0.02, 1},
    {"BunchOfColors5-VLA-v0", 0.015, 0.01, 1, 0.015, 0.01, 1},
    {"BunchOfColors7-Long-VLA-v0", 0.02, 0.025, 1, 0.02, 0.025, 1},
    {"BunchOfColors7-VLA-v0", 0.03, 0.02, 1, 0.03, 0.02, 1},
    {"InterceptFast-VLA-v0", 1, 1, 1, -1, -1, -1},
    {"InterceptMedium-VLA-v0", 1, 1, 1, -1, -1, -1},
    {"InterceptSlow-VLA-v0", 1, 1, 1, -1, -1, -1},
    {"InterceptGrabFast-VLA-v0", 1, 1, 1, -1, -1, -1},
    {"InterceptGrabMedium-VLA-v0", 1, 1, 1, -1, -1, -1},
    {"InterceptGrabSlow-VLA-v0", 1, 1, 1, -1, -1, -1},
    {"RotateLenientPosNeg-VLA-v0", 0.27, 0.975, 1, 0.25, 0.975, 1},
    {"RotateLenientPos-VLA-v0", 0.155, 0.855, 1, 0.135, 0.855, 1},
    {"RotateStrictPosNeg-VLA-v0", 0.28, 0.99, 1, 0.27, 0.99, 1},
    {"RotateStrictPos-VLA-v0", 0.135, 1, 1, 0.13, 1, 1},
    {"TraceShapeEasy-VLA-v0", 0.85, 1, 1, 0.85, 1, 1},
    {"TraceShapeHard-VLA-v0", 0.31, 1, 1, 0.235, 0.34, 0.99},
    {"TraceShapeMedium-VLA-v0", 0.53, 1, 1, 0.405, 0.475, 0.985},
    {"TraceShapeSeqEasy-VLA-v0", 0.235, 1, 1, 0.125, 0, 1},
    {"TraceShapeSeqHard-VLA-v0", 0.04, 1, 1, 0, 0, 0.985},
    {"TraceShapeSeqMedium-VLA-v0", 0.085, 1, 1, 0.02, 0, 0.965},
    {"BatteriesCheckerEasy-12-VLA-v0", 0.025, 1, 1, 0, 1, 1},
    {"BatteriesCheckerEasy-15-VLA-v0", 0.01, 1, 1, 0, 1, 1},
    {"BatteriesCheckerEasy-3-VLA-v0", 0.72, 1, 1, 0.65, 1, 1},
    {"BatteriesCheckerEasy-6-VLA-v0", 0.245, 1, 1, 0.115, 1, 1},
    {"BatteriesCheckerEasy-9-VLA-v0", 0.075, 1, 1, 0, 1, 1},
    {"BatteriesCheckerHard-12-VLA-v0", 0.01, 0.865, 1, 0, 0.865, 1},
    {"BatteriesCheckerHard-15-VLA-v0", 0.01, 0.845, 1, 0, 0.845, 1},
    {"BatteriesCheckerHard-3-VLA-v0", 0.72, 0.985, 1, 0.655, 0.985, 1},
    {"BatteriesCheckerHard-6-VLA-v0", 0.255, 0.935, 1, 0.11, 0.935, 1},
    {"BatteriesCheckerHard-9-VLA-v0", 0.095, 0.93, 1, 0.01, 0.93, 1},
    {"TakeItBack-VLA-v0", 0.42, 1, 1, 0.33, 0.23, 0.995},
    {"GatherAndRecall1-VLA-v0", 0.375, 1, 1, 0.375, 1, 1},
    {"GatherAndRecall3-VLA-v0", 0.355, 0.315, 1, 0.355, 0.315, 1},
    {"GatherAndRecall5-VLA-v0", 0.35, 0.365, 1, 0.35, 0.365, 1},
    {"GatherAndRecall7-VLA-v0", 0.35, 0.31, 1, 0.35, 0.31, 1},
    {"GatherAndRecall9-VLA-v0", 0.31, 0.29, 1, 0.31, 0.29, 1},
    {"TimedTransferEasy-Long-VLA-v0", 0.05, 1, 1, 0.05, 1, 1},
    {"TimedTransferEasy-VLA-v0", 0.08, 1, 1, 0.08, 1, 1},
    {"TimedTransferHard-Long-VLA-v0", 0.055, 1, 1, 0.055, 1, 1},
    {"TimedTransferHard-VLA-v0", 0.065, 1, 1, 0.065, 1, 1},
    {"TimedTransferMedium-Long-VLA-v0", 0.05, 1, 1, 0.05, 1, 1},
    {"TimedTransferMedium-VLA-v0", 0.055, 1, 1, 0.055, 1, 1},
    {"BlinkCountButtonPressEasy-VLA-v0", 0.34, 0.945, 1, 0.34, 0.945, 1},
    {"BlinkCountButtonPressEasy-Long-VLA-v0", 0.08, 0.29, 1, 0.08, 0.29, 1},
    {"BlinkCountButtonPressMedium-VLA-v0", 0.195, 0.925, 1, 0.195, 0.925, 1},
    {"BlinkCountButtonPressMedium-Long-VLA-v0", 0.07, 0.215, 1, 0.07, 0.215, 1},
    {"BlinkCountButtonPressHard-VLA-v0", 0.115, 0.88, 1, 0.115, 0.88, 1},
    {"BlinkCountButtonPressHard-Long-VLA-v0", 0.095, 0.18, 1, 0.095, 0.18, 1},
    // end vla
};

constexpr BaselineScores kRlBaselineScores[] = {
    // begin rl: written by tools/measure.py memory
    {"ShellGameTouch-v0", 0.29, 1, 1, 0.29, 0.295, 1},
    {"ShellGamePush-v0", 0.325, 1, 1, 0.325, 0.295, 1},
    {"ShellGamePick-v0", 0.31, 0.35, 1, 0.31, 0.35, 1},
    {"RememberColor3-v0", 0.31, 0.95, 1, 0.31, 0.31, 1},
    {"RememberColor5-v0", 0.185, 0.43, 1, 0.185, 0.185, 1},
    {"RememberColor9-v0", 0.095, 0.34, 1, 0.095, 0.14, 1},
    {"RememberShape3-v0", 0.335, 0.92, 1, 0.335, 0.31, 1},
    {"RememberShape5-v0", 0.19, 0.425, 1, 0.19, 0.165, 1},
    {"RememberShape9-v0", 0.145, 0.28, 1, 0.145, 0.075, 1},
    {"RememberShapeAndColor3x2-v0", 0.17, 0.335, 1, 0.17, 0.215, 1},
    {"RememberShapeAndColor3x3-v0", 0.105, 0.275, 1, 0.105, 0.11, 1},
    {"RememberShapeAndColor5x3-v0", 0.075, 0.21, 1, 0.075, 0.09, 1},
    {"SeqOfColors3-v0", 0.01, 0.01, 1, 0.01, 0.01, 1},
    {"SeqOfColors5-v0", 0.005, 0.005, 1, 0.005, 0.005, 1},
    {"SeqOfColors7-v0", 0.03, 0.02, 1, 0.03, 0.02, 1},
    {"ChainOfColors3-v0", 0, 0, 1, 0, 0, 1},
    {"ChainOfColors5-v0", 0, 0, 1, 0, 0, 1},
    {"ChainOfColors7-v0", 0, 0, 0.995, 0, 0, 0.995},
    {"BunchOfColors3-v0", 0.025, 0.02, 1, 0.025, 0.02, 1},
    {"BunchOfColors5-v0", 0.01, 0, 1, 0.01, 0, 1},
    {"BunchOfColors7-v0", 0.025, 0.01, 1, 0.025, 0.01, 1},
    {"InterceptSlow-v0", 0.99, 0.99, 0.99, -1, -1, -1},
    {"InterceptMedium-v0", 0.995, 0.995, 0.995, -1, -1, -1},
    {"InterceptFast-v0", 0.995, 0.995, 0.995, -1, -1, -1},
    {"InterceptGrabSlow-v0", 0.99, 0.99, 0.99, -1, -1, -1},
    {"InterceptGrabMedium-v0", 1, 1, 1, -1, -1, -1},
    {"InterceptGrabFast-v0", 1, 1, 1, -1, -1, -1},
    {"RotateLenientPos-v0", 0.12, 0.805, 1, 0.12, 0.805, 1},
    {"RotateLenientPosNeg-v0", 0.245, 0.81, 1, 0.245, 0.81, 1},
    {"RotateStrictPos-v0", 0.115, 0.815, 1, 0.115, 0.815, 1},
    {"RotateStrictPosNeg-v0", 0.27, 0.82, 1, 0.27, 0.82, 1},
    {"TakeItBack-v0", 0.36, 1, 1, 0.355, 0.5, 1},
    // end rl
};

}  // namespace

const BaselineScores* find_baseline_scores(std::string_view id) noexcept {
  for (const std::span<const BaselineScores> half :
       {std::span<const BaselineScores>(kBaselineScores), {kRlBaselineScores}}) {
    const auto found = std::ranges::find(half, id, &BaselineScores::id);
    if (found != half.end()) return &*found;
  }
  return nullptr;
}

std::optional<double> memory_score(const BaselineScores& baseline, double success_rate) noexcept {
  constexpr double kMinRange = 0.05;  // below that, differences are luck
  const double range = baseline.oracle - baseline.sweep;
  if (range < kMinRange) return std::nullopt;
  return std::max(-1.0, (success_rate - baseline.sweep) / range);
}

}  // namespace engram
