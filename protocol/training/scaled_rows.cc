#include "protocol/training/scaled_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "core/base/index.h"
#include "core/batch/batch_outputs.h"
#include "core/robot/robot_model.h"
#include "protocol/training/numbers.h"

namespace engram::training {
namespace {

using Layout = ObjectTokens::Layout;

constexpr int kPose = 7;
constexpr std::int32_t kUnseen = -1;

// Operations and their precision are those of the Python wrappers, for equal bits.

float clipped(double value) { return static_cast<float>(std::clamp(value, -kLimit, kLimit)); }

float clipped(float value) {
  constexpr auto kEnd = static_cast<float>(kLimit);
  return std::clamp(value, -kEnd, kEnd);
}

float* write_clipped(const float* values, int count, float* out) {
  return std::transform(values, values + count, out, [](float value) { return clipped(value); });
}

double joint_unit(int joint) { return joint < kArmJoints ? kAngle : kFinger; }

bool is_goal_pose(const std::string& name) {
  return name.starts_with("goal_") && name.ends_with("_pose") &&
         name.find_first_not_of("0123456789", 5) == name.size() - 5 && name.size() > 10;
}

// Whether a position is of something that is there.
bool is_there(const float* position) {
  bool near = true;
  bool any = false;
  for (int i = 0; i < 3; ++i) {
    near &= static_cast<double>(std::abs(position[i])) < kHidden;
    any |= position[i] != 0;
  }
  return near && any;
}

// A position from an origin, what follows it, and 1; zeros where nothing is there.
template <class T>
float* write_located(const float* values, int width, const T* origin, float* out) {
  if (!is_there(values)) return std::fill_n(out, width + 1, 0.0F);
  for (int i = 0; i < 3; ++i) {
    *out++ = clipped((static_cast<T>(values[i]) - origin[i]) / static_cast<T>(kLength));
  }
  out = write_clipped(values + 3, width - 3, out);
  *out++ = 1;
  return out;
}

}  // namespace

StateRows::StateRows(std::span<const RangedField> fields, int horizon) {
  tcp_ = offset_of("tcp_pose", fields);
  int offset = 0;
  for (const RangedField& field : fields) {
    if (is_goal_pose(field.field.name)) {
      goals_.push_back(offset);
      goal_width_ = std::min(field.field.width, kPose);
    } else {
      Part part = part_of(field.field, static_cast<float>(horizon));
      part.offset = offset;
      const bool flagged = part.kind == Kind::kPosition || part.kind == Kind::kDifference;
      dim_ += part.width + (flagged ? 1 : 0);
      parts_.push_back(part);
    }
    offset += field.field.width;
  }
  if (!goals_.empty()) dim_ += goal_width_ + 1;
}

StateRows::Part StateRows::part_of(const Field& field, float horizon) {
  Part part;
  part.width = field.width;
  if (field.name == "qpos") {
    part.kind = Kind::kJoints;
  } else if (field.name == "tcp_pose") {
    part.kind = Kind::kTcp;
  } else if (field.unit == "m" && (field.width == 3 || field.width == kPose)) {
    const bool difference = field.name.find("_to_") != std::string::npos;
    part.kind = difference ? Kind::kDifference : Kind::kPosition;
  } else if (field.unit == "m") {
    part.unit = static_cast<float>(kLength);
  } else if (field.unit == "rad") {
    part.unit = static_cast<float>(kAngle);
  } else if (field.unit == "m/s") {
    part.unit = static_cast<float>(kSpeed);
  } else if (field.unit == "rad/s" || field.name == "qvel") {
    part.unit = static_cast<float>(kTurnRate);
  } else if (field.unit == "control steps") {
    part.unit = horizon;
  }
  return part;
}

void StateRows::write(const float* row, float* out) const {
  const float* const tcp = row + tcp_;
  for (const Part& part : parts_) out = write_part(part, row + part.offset, tcp, out);
  if (!goals_.empty()) write_goal(row, tcp, out);
}

float* StateRows::write_part(const Part& part, const float* values, const float* tcp, float* out) {
  constexpr std::array<double, 3> kZero = {};
  switch (part.kind) {
    case Kind::kJoints:
      for (int i = 0; i < part.width; ++i) {
        *out++ = clipped((static_cast<double>(values[i]) - kRest[at(i)]) / joint_unit(i));
      }
      return out;
    case Kind::kTcp:
      for (int i = 0; i < 3; ++i) {
        *out++ = clipped((static_cast<double>(values[i]) - kRestTcp[at(i)]) / kLength);
      }
      return write_clipped(values + 3, part.width - 3, out);
    case Kind::kPosition:
      return write_located(values, part.width, tcp, out);
    case Kind::kDifference:
      return write_located(values, part.width, kZero.data(), out);
    case Kind::kPlain:
      break;
  }
  for (int i = 0; i < part.width; ++i) *out++ = clipped(values[i] / part.unit);
  return out;
}

void StateRows::write_goal(const float* row, const float* tcp, float* out) const {
  std::array<float, kPose> goal = {};
  for (const int offset : goals_) {
    for (int i = 0; i < goal_width_; ++i) goal[at(i)] += row[offset + i];
  }
  write_located(goal.data(), goal_width_, tcp, out);
}

ObjectRows::ObjectRows(std::span<const RangedField> fields, int num_envs)
    : first_(offset_of("object_0_seen", fields)),
      qpos_(offset_of("qpos", fields)),
      qvel_(offset_of("qvel", fields)),
      tcp_(offset_of("tcp_pose", fields)) {
  dim_ = row_width(fields);
  tokens_ = (dim_ - first_) / Layout::kWidth;
  order_.resize(at(num_envs) * at(tokens_));
  looks_.resize(order_.size(), kUnseen);
}

namespace {

// The number of the 1 in a one-hot part, from 1 on; 0: none.
std::int32_t named(const float* begin, int count) {
  const float* const most = std::max_element(begin, begin + count);
  return *most != 0 ? static_cast<std::int32_t>(most - begin) + 1 : 0;
}

std::int32_t looks_of(const float* token) {
  constexpr std::int32_t kBase = 20;  // more than any part has names
  if (!(token[Layout::kSeen] > 0)) return kUnseen;
  const std::int32_t kind = named(token + Layout::kKind, Layout::kWidth - Layout::kKind);
  const std::int32_t shape = named(token + Layout::kShape, Layout::kState - Layout::kShape);
  const std::int32_t color = named(token + Layout::kColor, Layout::kShape - Layout::kColor);
  return (kind * kBase + shape) * kBase + color;
}

// Rounded to 1/1000, so that equal objects keep their order while they tremble.
float left_to_right(const float* token) {
  constexpr float kSteps = 1000;
  return std::nearbyint(token[Layout::kPosition + 1] * kSteps) / kSteps;
}

}  // namespace

void ObjectRows::write(int env, const float* row, bool begins, float* out) {
  const float* const tokens = row + first_;
  std::int32_t* const looks = looks_.data() + at(env) * at(tokens_);
  bool changed = begins;
  for (int i = 0; i < tokens_; ++i) {
    const std::int32_t now = looks_of(tokens + i * Layout::kWidth);
    changed |= now != looks[i] && now >= 0;
    looks[i] = now;
  }
  if (changed) sort(env, tokens);
  write_last(env, row, out);
}

// Sorts by insertion: few tokens, and no memory.
void ObjectRows::sort(int env, const float* tokens) {
  const std::int32_t* const looks = looks_.data() + at(env) * at(tokens_);
  std::uint8_t* const order = order_.data() + at(env) * at(tokens_);
  const auto before = [&](int a, int b) {
    if ((looks[a] < 0) != (looks[b] < 0)) return looks[b] < 0;
    if (looks[a] != looks[b]) return looks[a] < looks[b];
    return left_to_right(tokens + a * Layout::kWidth) < left_to_right(tokens + b * Layout::kWidth);
  };
  for (int i = 0; i < tokens_; ++i) {
    int place = i;
    for (; place > 0 && before(i, order[place - 1]); --place) order[place] = order[place - 1];
    order[place] = static_cast<std::uint8_t>(i);
  }
}

void ObjectRows::write_last(int env, const float* row, float* out) const {
  constexpr auto kScale = static_cast<float>(ObjectTokens::kPositionScale);
  constexpr auto kUnit = static_cast<float>(kLength);
  constexpr auto kTurn = static_cast<float>(std::numbers::pi / kTurnRate);
  write_clipped(row, first_, out);
  for (int i = 0; i < kRobotJoints; ++i) {
    const double range = i < kArmJoints ? std::numbers::pi : kFinger;
    const double angle = static_cast<double>(row[qpos_ + i]) * range;
    out[qpos_ + i] = clipped((angle - kRest[at(i)]) / joint_unit(i));
    out[qvel_ + i] = clipped(row[qvel_ + i] * kTurn);
  }
  std::array<float, 3> tcp{};
  for (int i = 0; i < 3; ++i) {
    tcp[at(i)] = row[tcp_ + i] * kScale;
    out[tcp_ + i] = clipped((static_cast<double>(tcp[at(i)]) - kRestTcp[at(i)]) / kLength);
  }
  const std::uint8_t* const order = order_.data() + at(env) * at(tokens_);
  for (int place = 0; place < tokens_; ++place) {
    const float* const token = row + first_ + order[place] * Layout::kWidth;
    float* const to = out + first_ + place * Layout::kWidth;
    write_clipped(token, Layout::kWidth, to);
    for (int i = 0; i < 3; ++i) {
      const float offset = kScale * token[Layout::kPosition + i] - tcp[at(i)];
      to[Layout::kPosition + i] = clipped(offset / kUnit * token[Layout::kSeen]);
    }
  }
}

}  // namespace engram::training
