#include "protocol/eval/policies/object_text.h"

#include <algorithm>
#include <cmath>

#include "core/base/index.h"
#include "core/batch/queries.h"
#include "core/observe/object_tokens.h"
#include "core/observe/object_words.h"

namespace engram {
namespace {

using Layout = ObjectTokens::Layout;
using Values = std::span<const float>;

constexpr std::size_t kFirstFinger = kArmJoints;  // in the row, both
constexpr double kTenth = 0.1;
constexpr double kMinPress = 0.05;  // of a button's travel

std::string place(Values position) {
  std::string text;
  const char* const axes[] = {"x ", ", y ", ", z "};
  for (std::size_t i = 0; i < std::size(axes); ++i) {
    const double metres = static_cast<double>(position[i]) * ObjectTokens::kPositionScale;
    text += axes[i] + in_metres(metres);
  }
  return text;
}

// Index of the one value that is not 0, -1: none is.
int hot(Values token, int at, std::size_t width) {
  const Values part = token.subspan(static_cast<std::size_t>(at), width);
  const auto found = std::ranges::find_if(part, [](float value) { return value > 0; });
  return found == part.end() ? -1 : static_cast<int>(found - part.begin());
}

// A share in whole tenths, "40 %".
std::string in_tenths(double share) {
  return std::to_string(10 * std::lround(std::clamp(share, 0.0, 1.0) / kTenth)) + " %";
}

std::string describe_token(Values token) {
  const int kind = hot(token, Layout::kKind, kObjectKindNames.size());
  const int color = hot(token, Layout::kColor, kObjectColorNames.size());
  const int shape = hot(token, Layout::kShape, kObjectShapeNames.size());
  const auto of_kind = static_cast<ObjectKind>(kind + 1);  // kPart has no token
  std::string text(color < 0 ? "" : std::string(kObjectColorNames[at(color)]) + " ");
  text += of_kind == ObjectKind::kObject ? shape_word(shape)
                                         : std::string(kObjectKindNames[at(std::max(kind, 0))]);
  text += " at " + place(token.subspan(Layout::kPosition, 3));
  const double state = static_cast<double>(token[Layout::kState]);
  if (of_kind == ObjectKind::kLamp) text += state > 0 ? ", lit" : ", off";
  if (of_kind == ObjectKind::kButton && state > kMinPress) text += ", pressed " + in_tenths(state);
  return text;
}

}  // namespace

ObjectText::ObjectText(const Batch& batch) {
  for (const RangedField& part : Queries(batch).ranged_fields()) {
    if (part.field.name == "object_0_seen") break;
    tokens_ += static_cast<std::size_t>(part.field.width);
  }
}

std::string ObjectText::describe(Values row) const {
  constexpr std::size_t kTcp = 2 * kRobotJoints;  // offset
  const double opening = static_cast<double>(row[kFirstFinger] + row[kFirstFinger + 1]) / 2;
  std::string text = "hand at " + place(row.subspan(kTcp, 3)) + ", " + in_tenths(opening) + " open";
  int hidden = 0;
  for (std::size_t i = tokens_; i + Layout::kWidth <= row.size(); i += Layout::kWidth) {
    const Values token = row.subspan(i, Layout::kWidth);
    if (token[Layout::kSeen] > 0) {
      text += "; " + describe_token(token);
    } else {
      ++hidden;
    }
  }
  if (hidden > 0)
    text += "; " + std::to_string(hidden) + (hidden == 1 ? " object" : " objects") + " hidden";
  return text;
}

}  // namespace engram
