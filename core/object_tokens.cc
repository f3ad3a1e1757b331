#include "core/object_tokens.h"

#include <algorithm>
#include <array>
#include <string>

#include "core/base/error.h"
#include "core/episode.h"

namespace engram {
namespace {

using Layout = ObjectTokens::Layout;
constexpr int kMostProps = 64;

}  // namespace

ObjectTokens::ObjectTokens(const std::vector<ObjectLook>& looks) {
  if (looks.size() > kMostProps) throw Error(Error::kInternal, "more than 64 props in a task");
  for (std::size_t prop = 0; prop < looks.size(); ++prop) {
    const ObjectLook& look = looks[prop];
    if (look.kind == ObjectKind::kPart) continue;
    Object object{static_cast<int>(prop), look, std::vector<float>(Layout::kWidth)};
    const auto set = [&object](int at, double value) {
      object.token[static_cast<std::size_t>(at)] = static_cast<float>(value);
    };
    set(Layout::kSeen, 1);
    for (int i = 0; i < 3; ++i) {
      set(Layout::kSize + i, look.half_size[static_cast<std::size_t>(i)] / kSizeScale);
    }
    set(Layout::kColor + look.color, 1);
    if (look.shape >= 0) set(Layout::kShape + look.shape, 1);
    set(Layout::kKind + static_cast<int>(look.kind) - 1, 1);
    objects_.push_back(std::move(object));
  }
}

void ObjectTokens::bind(ColumnStore& memory) {
  seen_ = memory.add<std::uint64_t>("tokens_seen");
  epoch_ = memory.add<std::int32_t>("token_epoch");
  const int width = std::max(1, tokens());
  order_ = memory.add<std::uint8_t>("token_order", width);
  memory.limit("token_order", 0, width - 1);
}

std::vector<Field> ObjectTokens::fields() const {
  std::vector<Field> fields;
  for (int i = 0; i < tokens(); ++i) {
    const std::string name = "object_" + std::to_string(i) + "_";
    const auto add = [&](const char* what, int width, const char* unit, const char* about) {
      fields.push_back({name + what, width, DType::kFloat32, unit, about});
    };
    add("seen", 1, "", "1: it can be seen; 0: all else is 0 too");
    add("position", 3, "0.5 m", "world frame");
    add("orientation", 4, "", "quaternion (w, x, y, z), w >= 0");
    add("size", 3, "0.05 m", "half sides of the box around it, its own axes");
    add("color", static_cast<int>(kObjectColorNames.size()), "",
        "red, green, blue, yellow, magenta, cyan, maroon, orange, teal, white, grey, black");
    add("shape", static_cast<int>(kObjectShapeNames.size()), "",
        "cube, sphere, cylinder, cross, torus, star, pyramide, t_shape, crescent");
    add("state", 1, "", "of a lamp: 1 lit; of a button: how far it is pressed");
    add("kind", static_cast<int>(kObjectKindNames.size()), "",
        "object, ball, cup, battery, peg, place, rack, button, lamp");
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
  std::array<int, kMostProps> order{};
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
  const std::uint8_t* place = order_.row(env);
  for (const Object& object : objects_) {
    float* token = out + *place++ * Layout::kWidth;
    if ((seen >> object.prop & 1) == 0) {
      std::fill_n(token, Layout::kWidth, 0.0F);
    } else {
      fill(state, env, object, token);
    }
  }
}

void ObjectTokens::fill(const State& state, int env, const Object& object, float* token) {
  std::ranges::copy(object.token, token);
  const double* pos = state.prop_pos_of(env, object.prop);
  for (int i = 0; i < 3; ++i) {
    token[Layout::kPosition + i] = static_cast<float>(pos[i] * (1 / kPositionScale));
  }
  const double* quat = state.prop_quat_of(env, object.prop);
  const double sign = quat[0] < 0 ? -1 : 1;
  for (int i = 0; i < 4; ++i) {
    token[Layout::kOrientation + i] = static_cast<float>(sign * quat[i]);
  }
  if (object.look.kind == ObjectKind::kLamp) {
    token[Layout::kState] = state.prop_emission.row(env)[object.prop] > 0 ? 1.0F : 0.0F;
  } else if (object.look.kind == ObjectKind::kButton) {
    const double sunk = (object.look.rest_height - pos[2]) / object.look.travel;
    token[Layout::kState] = static_cast<float>(std::clamp(sunk, 0.0, 1.0));
  }
  const float* painted = state.prop_rgba.row(env) + 4 * static_cast<std::ptrdiff_t>(object.prop);
  if (painted[3] > 0) {
    token[Layout::kColor + object.look.color] = 0;
    const int color =
        nearest_object_color(static_cast<double>(painted[0]), static_cast<double>(painted[1]),
                             static_cast<double>(painted[2]));
    token[Layout::kColor + color] = 1;
  }
}

}  // namespace engram
