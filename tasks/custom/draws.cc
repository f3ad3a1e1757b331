#include "tasks/custom/draws.h"

#include <algorithm>
#include <numeric>

#include "core/base/error.h"
#include "core/base/join.h"

namespace engram::tasks {
namespace {

constexpr int kTriesOfPlace = 200;
constexpr int kTriesOfAll = 200;

using Kind = CustomDraw::Kind;

bool is_far(const double* places, std::size_t count, double x, double y, double distance) {
  for (std::size_t i = 0; i < count; ++i) {
    const double dx = places[2 * i] - x;
    const double dy = places[2 * i + 1] - y;
    if (dx * dx + dy * dy < distance * distance) return false;
  }
  return true;
}

// One place after the other, each drawn until it is far from those before. False if one does not
// fit.
bool try_places(const CustomDraw& draw, RandomStream& random, double* out) {
  const auto count = static_cast<std::size_t>(draw.width) / 2;
  for (std::size_t i = 0; i < count; ++i) {
    int tries = 0;
    do {
      if (++tries > kTriesOfPlace) return false;
      out[2 * i] = random.uniform(draw.area_low[0], draw.area_high[0]);
      out[2 * i + 1] = random.uniform(draw.area_low[1], draw.area_high[1]);
    } while (!is_far(out, i, out[2 * i], out[2 * i + 1], draw.min_distance));
  }
  return true;
}

bool sample_places(const CustomDraw& draw, RandomStream& random, double* out) {
  for (int i = 0; i < kTriesOfAll; ++i) {
    if (try_places(draw, random, out)) return true;
  }
  return false;
}

std::string do_not_fit(const CustomDraw& draw) {
  return "draw '" + draw.name + "': " + std::to_string(draw.width / 2) + " places " +
         shortest(draw.min_distance) + " m apart do not fit into their area";
}

void check_places(const CustomDraw& draw) {
  std::vector<double> places(static_cast<std::size_t>(draw.width));
  for (std::uint32_t i = 0; i < 20; ++i) {
    RandomStream random(0, i, 0);
    if (sample_places(draw, random, places.data())) continue;
    throw Error(Error::kInvalidArgument, do_not_fit(draw));
  }
}

// The first `width` of a permutation.
void sample_distinct(const CustomDraw& draw, RandomStream random, std::int32_t* out) {
  std::vector<int> all(static_cast<std::size_t>(draw.high) + 1);
  random.permutation(all);
  std::copy_n(all.begin(), draw.width, out);
}

}  // namespace

std::string draw_column(const std::string& name) { return "draw:" + name; }

CustomDraws::CustomDraws(std::vector<CustomDraw> draws) : draws_(std::move(draws)) {
  for (const CustomDraw& draw : draws_) {
    if (draw.kind == Kind::kPlaces) check_places(draw);
  }
}

std::vector<RandomVariable> CustomDraws::variables() const {
  std::vector<RandomVariable> variables;
  for (const CustomDraw& draw : draws_) {
    variables.push_back({.name = draw.name,
                         .width = draw.width,
                         .integer = !draw.is_real(),
                         .low = draw.low,
                         .high = draw.high,
                         .unit = draw.unit,
                         .description = draw.text,
                         .distinct = draw.kind == Kind::kOrder || draw.kind == Kind::kChoice,
                         .constant = draw.constant});
  }
  return variables;
}

std::vector<Field> CustomDraws::fields() const {
  std::vector<Field> fields;
  for (const CustomDraw& draw : draws_) {
    fields.push_back({draw.name, draw.width, draw.is_real() ? DType::kFloat32 : DType::kInt32,
                      draw.unit, draw.text, true});
  }
  return fields;
}

void CustomDraws::bind(ColumnStore& memory) {
  integers_.resize(draws_.size());
  reals_.resize(draws_.size());
  for (std::size_t i = 0; i < draws_.size(); ++i) {
    const CustomDraw& draw = draws_[i];
    const std::string column = draw_column(draw.name);
    if (draw.is_real()) {
      reals_[i] = memory.add<double>(column, draw.width, draw.unit, draw.text);
      continue;
    }
    integers_[i] = memory.add<std::int32_t>(column, draw.width, draw.unit, draw.text);
    memory.limit(column, static_cast<int>(draw.low), static_cast<int>(draw.high));
  }
}

void CustomDraws::sample(const Episode& episode) const {
  const int env = episode.env();
  for (std::size_t i = 0; i < draws_.size(); ++i) {
    const CustomDraw& draw = draws_[i];
    const int variable = static_cast<int>(i);
    const double* pinned = episode.pinned(variable);
    double low = draw.low;
    double high = draw.high;
    episode.narrow(variable, low, high);
    RandomStream random = episode.stream(variable);
    if (draw.is_real()) {
      double* out = reals_[i].row(env);
      if (pinned != nullptr) {
        std::copy_n(pinned, draw.width, out);
      } else if (draw.kind == Kind::kReal) {
        std::generate_n(out, draw.width, [&] { return random.uniform(low, high); });
      } else if (!sample_places(draw, random, out)) {
        throw Error(Error::kTaskFailed, do_not_fit(draw));
      }
      continue;
    }
    std::int32_t* out = integers_[i].row(env);
    if (pinned != nullptr) {
      std::transform(pinned, pinned + draw.width, out,
                     [](double value) { return static_cast<std::int32_t>(value); });
    } else if (draw.kind == Kind::kInteger) {
      std::generate_n(out, draw.width, [&] {
        return random.integer(static_cast<int>(low), static_cast<int>(high));
      });
    } else {
      sample_distinct(draw, random, out);
    }
  }
}

void CustomDraws::write(int env, float* out) const {
  for (std::size_t i = 0; i < draws_.size(); ++i) {
    for (int k = 0; k < draws_[i].width; ++k) {
      *out++ = static_cast<float>(draws_[i].is_real() ? reals_[i].row(env)[k]
                                                      : integers_[i].row(env)[k]);
    }
  }
}

std::optional<std::string> CustomDraws::text_of(std::string_view name, int env) const {
  const auto draw = std::ranges::find(draws_, name, &CustomDraw::name);
  if (draw == draws_.end()) return std::nullopt;
  const auto i = static_cast<std::size_t>(draw - draws_.begin());
  if (draw->is_real()) return shortest(reals_[i][env]);
  if (draw->names.empty()) return std::to_string(integers_[i][env]);
  const std::span values(integers_[i].row(env), static_cast<std::size_t>(draw->width));
  return join(values, [&](std::int32_t value) {
    return draw->names[static_cast<std::size_t>(value - static_cast<std::int32_t>(draw->low))];
  });
}

std::string CustomDraws::filled(std::string text, int env, const Instead& instead_of) const {
  for (std::size_t open = text.find('{'); open != std::string::npos; open = text.find('{', open)) {
    const std::size_t close = text.find('}', open);
    if (close == std::string::npos) break;
    const std::string name = text.substr(open + 1, close - open - 1);
    std::optional<std::string> value = instead_of ? instead_of(name) : std::nullopt;
    if (!value) value = text_of(name, env);
    if (value) text.replace(open, close - open + 1, *value);
    open += value ? value->size() : 1;
  }
  return text;
}

}  // namespace engram::tasks
