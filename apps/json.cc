#include "apps/json.h"

#include <cmath>

namespace engram::apps {
namespace {

struct Converter {
  Json operator()(std::nullptr_t /*nothing*/) const { return nullptr; }
  Json operator()(bool truth) const { return truth; }
  Json operator()(std::int64_t number) const { return number; }
  Json operator()(std::uint64_t number) const { return number; }
  Json operator()(double number) const { return to_json(number); }
  Json operator()(const std::string& text) const { return text; }
  Json operator()(const ConstantTable& table) const { return to_json(table); }
  Json operator()(const ConstantList& list) const {
    Json array = Json::array();
    for (const Constant& item : list) array.push_back(to_json(item));
    return array;
  }
};

}  // namespace

Json to_json(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json to_json(const Constant& constant) { return std::visit(Converter(), constant.value); }

Json to_json(const ConstantTable& table) {
  Json object = Json::object();
  for (const auto& [name, constant] : table) object[name] = to_json(constant);
  return object;
}

std::string to_text(const Json& document) {
  return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace engram::apps
