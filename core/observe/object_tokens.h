// The objects observation: as much of the scene as the sensors' cameras show, as numbers. A token
// for every object; one that is hidden, or covered by another object, has a token of zeros.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/column.h"
#include "core/base/field.h"
#include "core/sim/state.h"
#include "core/task/object_descriptor.h"

namespace engram {

// A part of a row, and the range of its values.
struct RangedField {
  Field field;
  double low = 0;
  double high = 1;
  std::vector<std::string> names;  // of the values of a one-hot part
};

class ObjectTokens {
 public:
  // Offsets of a token's values.
  struct Layout {
    static constexpr int kSeen = 0;
    static constexpr int kPosition = 1;
    static constexpr int kOrientation = 4;
    static constexpr int kSize = 8;
    static constexpr int kColor = 11;
    static constexpr int kShape = kColor + static_cast<int>(kObjectColorNames.size());
    static constexpr int kState = kShape + static_cast<int>(kObjectShapeNames.size());
    static constexpr int kKind = kState + 1;
    static constexpr int kWidth = kKind + static_cast<int>(kObjectKindNames.size());
  };
  // Positions and sizes are divided by these, m.
  static constexpr double kPositionScale = 0.5;
  static constexpr double kSizeScale = 0.05;
  // Scaled quantities are cut off here: an object that flies off the table stays a number for
  // networks.
  static constexpr double kMax = 10;
  // NaN stays NaN.
  static float cut_off(double value) {
    constexpr auto kEnd = static_cast<float>(kMax);
    const auto number = static_cast<float>(value);
    return std::abs(number) > kEnd ? std::copysign(kEnd, number) : number;
  }

  // descriptors: of the props, in the scene's order. Throws Error if they are more than 64.
  explicit ObjectTokens(const std::vector<ObjectDescriptor>& descriptors);

  // Adds the columns of each environment's order of tokens.
  void bind(ColumnStore& memory);

  int tokens() const { return static_cast<int>(objects_.size()); }
  int width() const { return tokens() * Layout::kWidth; }
  // The values of a row of tokens, with units and ranges.
  std::vector<RangedField> fields() const;

  // Writes a row of tokens. Their order is drawn anew whenever something comes into view. key: of
  // the episode's random streams.
  void write(const State& state, int env, std::uint64_t key, float* out) const;

 private:
  struct Object {
    int prop = 0;
    ObjectDescriptor descriptor;
    std::array<float, Layout::kWidth> token{};  // constant values
  };

  std::uint64_t in_view(const State& state, int env) const;
  void draw_order(const State& state, int env, std::uint64_t key) const;
  static void fill(const State& state, int env, const Object& object, float* token);

  std::vector<Object> objects_;
  Column<std::uint64_t> seen_;  // bits of props, in the last observation
  Column<std::int32_t> epoch_;  // number of times something has come into view
  Column<std::uint8_t> order_;  // (tokens) place of every object's token
};

}  // namespace engram
