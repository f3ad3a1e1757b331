#include "protocol/json.h"

#include <charconv>
#include <cmath>

namespace engram {

Json to_json(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json to_json(float value) {
  if (!std::isfinite(value)) return nullptr;
  char text[32];
  const char* end = std::to_chars(text, text + sizeof text, value).ptr;
  double shortest = 0;
  std::from_chars(text, end, shortest);
  return shortest;
}

Json to_json(const ConstantTable& table) {
  Json object = Json::object();
  for (const auto& [name, constant] : table) object[name] = to_json(constant);
  return object;
}

Json to_json(const Constant& constant) {
  if (const auto* number = std::get_if<int>(&constant.value)) return *number;
  if (const auto* number = std::get_if<double>(&constant.value)) return to_json(*number);
  if (const auto* text = std::get_if<std::string>(&constant.value)) return *text;
  if (const auto* table = std::get_if<ConstantTable>(&constant.value)) return to_json(*table);
  Json array = Json::array();
  for (const Constant& item : std::get<ConstantList>(constant.value)) {
    array.push_back(to_json(item));
  }
  return array;
}

Json parse_json(std::string_view text) {
  constexpr int kDeepest = 64;
  struct TooDeep {};
  const auto check = [](int depth, Json::parse_event_t /*event*/, const Json& /*parsed*/) {
    if (depth > kDeepest) throw TooDeep();
    return true;
  };
  try {
    return Json::parse(text, check, false);
  } catch (const TooDeep&) {
    return Json(Json::value_t::discarded);
  }
}

std::string to_text(const Json& document) {
  return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace engram
