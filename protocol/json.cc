#include "protocol/json.h"

#include <cmath>

namespace engram {
namespace {

// The text of a value that nests no other.
std::string scalar_text(const Json& value) {
  return value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void begin_line(int depth, std::string& text) {
  constexpr int kIndentation = 2;
  text += '\n';
  text.append(static_cast<std::size_t>(kIndentation * depth), ' ');
}

void append(const Constant& constant, int depth, std::string& text) {
  const auto* list = std::get_if<ConstantList>(&constant.value);
  const auto* table = std::get_if<ConstantTable>(&constant.value);
  if (list == nullptr && table == nullptr) {
    text += scalar_text(to_json(constant));
    return;
  }
  const std::size_t size = list != nullptr ? list->size() : table->size();
  text += list != nullptr ? '[' : '{';
  for (std::size_t i = 0; i < size; ++i) {
    if (i > 0) text += ',';
    begin_line(depth + 1, text);
    if (table != nullptr) text += scalar_text((*table)[i].first) + ": ";
    append(list != nullptr ? (*list)[i] : (*table)[i].second, depth + 1, text);
  }
  if (size > 0) begin_line(depth, text);
  text += list != nullptr ? ']' : '}';
}

}  // namespace

Json to_json(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json to_json(const ConstantTable& table) {
  Json object = Json::object();
  for (const auto& [name, constant] : table) object[name] = to_json(constant);
  return object;
}

Json to_json(const Constant& constant) {
  if (const auto* truth = std::get_if<bool>(&constant.value)) return *truth;
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

std::string to_text(const Constant& document) {
  std::string text;
  append(document, 0, text);
  return text + "\n";
}

}  // namespace engram
