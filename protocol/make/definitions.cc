#include "protocol/make/definitions.h"

#include <string_view>

#include "core/base/error.h"
#include "protocol/io/json_values.h"
#include "tasks/family_content.h"

namespace engram {
namespace {

constexpr std::size_t kShownDigits = 8;

std::string beginning(const Json& definition) {
  const auto* hash = std::get_if<std::string>(&definition.value);
  return hash == nullptr ? "none" : hash->substr(0, kShownDigits);
}

}  // namespace

Json definition_of(const RegistryEntry& entry) {
  const std::string content = content_of(*entry.definition);
  return content.empty() ? Json() : Json(content);
}

JsonTable definitions_of(const std::vector<std::string>& ids) {
  JsonTable definitions;
  for (const std::string& id : ids) {
    Json definition = definition_of(require_entry(id));
    if (!is_null(definition)) definitions.emplace_back(id, std::move(definition));
  }
  return definitions;
}

void require_same_definition(const std::string& id, const Json& first, const std::string& there,
                             const Json& other, const std::string& here) {
  if (first == other) return;
  throw Error(Error::kInvalidArgument, "task '" + id +
                                           "' has two definitions: " + beginning(first) + " in " +
                                           there + ", " + beginning(other) + " in " + here +
                                           "; the same file of the task, with those that "
                                           "it imports, needed");
}

void require_definitions(const std::vector<std::string>& ids, const Json& table,
                         const std::string& there) {
  for (const std::string& id : ids) {
    require_same_definition(id, value_or_null(table, id), there, definition_of(require_entry(id)));
  }
}

}  // namespace engram
