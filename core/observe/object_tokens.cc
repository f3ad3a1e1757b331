#include "core/observe/object_tokens.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <string>

#include "core/base/error.h"
#include "core/base/index.h"
#include "core/base/join.h"
#include "core/task/episode.h"

namespace engram {
namespace {

using Layout = ObjectTokens::Layout;
constexpr int kMaxProps = 64;

}  // namespace

ObjectTokens::ObjectTokens(const std::vector<ObjectDescriptor>& descriptors) {
  if (descriptors.size() > kMaxProps) throw Error(Error::kInternal, "more than 64 props in a task");
  for (std::size_t prop = 0; prop < descriptors.size(); ++prop) {
    const ObjectDescriptor& descriptor = descriptors[prop];
    if (descriptor.kind == ObjectKind::kPart) continue;
    Object object{static_cast<int>(prop), descriptor};
    const auto set = [&object](int at, double value) {
      object.token[static_cast<std::size_t>(at)] = static_cast<float>(value);
    };
    set(Layout::kSeen, 1);
    for (int i = 0; i < 3; ++i) {
      const double scaled = descriptor.half_size[at(i)] / kSizeScale;
      set(Layout::kSize + i, std::min(scaled, kMax));
    }
    set(Layout::kColor + descriptor.color, 1);
    if (descriptor.shape >= 0) set(Layout::kShape + descriptor.shape, 1);
    set(Layout::kKind + static_cast<int>(descriptor.kind) - 1, 1);
    objects_.push_back(object);
  }
}

void ObjectTokens::bind(ColumnStore& memory) {
  seen_ = memory.add<std::uint64_t>("tokens_seen");
  epoch_ = memory.add<std::int32_t>("token_epoch");
  const int width = std::max(1, tokens());
  order_ = memory.add<std::uint8_t>("token_order", width);
  memory.limit("token_order", 0, width - 1);
}

std::vector<RangedField> ObjectTokens::fields() const {
  std::vector<RangedField> fields;
  for (int i = 0; i < tokens(); ++i) {
    const std::string name = "object_" + std::to_string(i) + "_";
    const auto add = [&](const char* what, int width, double low, double high, const char* unit,
                         const char* about) {
      fields.push_back({{name + what, width, DType::kFloat32, unit, about}, low, high, {}});
    };
    const auto add_one_hot = [&](const char* what, const auto& names) {
      const int width = static_cast<int>(names.size());
      fields.push_back({{name + what, width, DType::kFloat32, "", "one of: " + join(names)},
                        0,
                        1,
                        {names.begin(), names.end()}});
    };
    add("seen", 1, 0, 1, "", "1: it can be seen; 0: all else is 0 too");
    add("position", 3, -kMax, kMax, "0.5 m", "world frame");
    add("orientation", 4, -1, 1, "", "quaternion (w, x, y, z), w >= 0");
    add("size", 3, 0, kMax, "0.05 m", "half sides of the box around it, its own axes");
    add_one_hot("color", kObjectColorNames);
    add_one_hot("shape", kObjectShapeNames);
    add("state", 1, 0, 1, "", "of a lamp: 1 lit; of a button: how far it is pressed");
    add_one_hot("kind", kObjectKindNames);
  }
  return fields;
}

std::uint64_t ObjectTokens::in_view(const State& state, int env) const {
  std::uint64_t seen = 0;
  for (const Object& object : objects_) {
    const bool there = state.status_of(env, object.prop) != PropStatus::kHidden;
    seen |= std::uint64_t{there} << object.prop;
  }
  return seen & ~state.covered[env];
}

void ObjectTokens::draw_order(const State& state, int env, std::uint64_t key) const {
  std::array<int, kMaxProps> order{};
  const std::span places = std::span(order).first(objects_.size());
  const auto purpose = kPurposeTokenOrder + static_cast<std::uint32_t>(epoch_[env] & 0xffff);
  RandomStream(key, state.episode[env], purpose).permutation(places);
  std::ranges::transform(places, order_.row(env),
                         [](int place) { return static_cast<std::uint8_t>(place); });
}

void ObjectTokens::write(const State& state, int env, std::uint64_t key, float* out) const {
  const std::uint64_t seen = in_view(state, env);
  if ((seen & ~seen_[env]) != 0) {
    ++epoch_[env];
    draw_order(state, env, key);
  }
  seen_[env] = seen;
  if (std::popcount(seen) < tokens()) std::fill_n(out, width(), 0.0F);
  const std::uint8_t* place = order_.row(env);
  for (const Object& object : objects_) {
    float* token = out + *place++ * Layout::kWidth;
    if ((seen >> object.prop & 1) != 0) fill(state, env, object, token);
  }
}

void ObjectTokens::fill(const State& state, int env, const Object& object, float* token) {
  std::memcpy(token, object.token.data(), sizeof object.token);
  const double* pos = state.prop_pos_of(env, object.prop);
  for (int i = 0; i < 3; ++i) {
    token[Layout::kPosition + i] = cut_off(pos[i] * (1 / kPositionScale));
  }
  const double* quat = state.prop_quat_of(env, object.prop);
  const double sign = quat[0] < 0 ? -1 : 1;
  for (int i = 0; i < 4; ++i) {
    token[Layout::kOrientation + i] = static_cast<float>(sign * quat[i]);
  }
  if (object.descriptor.kind == ObjectKind::kLamp) {
    token[Layout::kState] = state.prop_emission.row(env)[object.prop] > 0 ? 1.0F : 0.0F;
  } else if (object.descriptor.kind == ObjectKind::kButton) {
    const double sunk = (object.descriptor.rest_height - pos[2]) / object.descriptor.travel;
    token[Layout::kState] = static_cast<float>(std::clamp(sunk, 0.0, 1.0));
  }
  const float* painted = state.prop_rgba.row(env) + 4 * static_cast<std::ptrdiff_t>(object.prop);
  if (painted[3] > 0) {
    token[Layout::kColor + object.descriptor.color] = 0;
    const int color =
        nearest_object_color(static_cast<double>(painted[0]), static_cast<double>(painted[1]),
                             static_cast<double>(painted[2]));
    token[Layout::kColor + color] = 1;
  }
}

}  // namespace engram
