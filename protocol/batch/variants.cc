#include "protocol/batch/variants.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <mutex>
#include <vector>

#include "core/base/error.h"
#include "core/base/join.h"
#include "protocol/formats/files.h"
#include "tasks/variants.h"

namespace engram {
namespace {

constexpr const char* kFileVariable = "ENGRAM_VARIANTS";
constexpr std::array kKeys = {"id", "base", "constants", "instruction"};

[[noreturn]] void refuse(std::string_view what, const std::string& why) {
  throw Error(Error::kInvalidArgument, std::string(what) + ": " + why);
}

// The text under a key; "" where the key is missing and need not be there.
std::string text_of(const Document& document, const char* key, bool needed, std::string_view what) {
  const Document* found = find(document, key);
  if (found == nullptr && !needed) return "";
  const auto* value = found == nullptr ? nullptr : std::get_if<std::string>(&found->value);
  if (value == nullptr) refuse(what, std::string("a text '") + key + "' needed");
  return *value;
}

std::vector<VariantDefinition> definitions_of(const Document& document, const std::string& what) {
  const Document* variants = find(document, "variants");
  const auto* list = variants == nullptr ? nullptr : std::get_if<DocumentList>(&variants->value);
  if (list == nullptr) refuse(what, R"(not of the form {"variants": [...]})");
  std::vector<VariantDefinition> definitions;
  for (const Document& one : *list) definitions.push_back(to_definition(one, what));
  return definitions;
}

}  // namespace

ConstantTable parse_constants(std::string_view json) {
  std::optional<Document> document = parse_document(json);
  auto* table = document ? std::get_if<DocumentTable>(&document->value) : nullptr;
  if (table == nullptr) {
    refuse("constants",
           "'" + std::string(json) + R"(' given, a JSON object such as {"COLORS": 7} needed)");
  }
  return std::move(*table);
}

Document to_document(const VariantDefinition& definition) {
  DocumentTable table = {
      {"id", definition.id}, {"base", definition.base}, {"constants", definition.constants}};
  if (!definition.instruction.empty()) table.emplace_back("instruction", definition.instruction);
  return table;
}

VariantDefinition to_definition(const Document& document, std::string_view what) {
  const auto* keys = std::get_if<DocumentTable>(&document.value);
  if (keys == nullptr) refuse(what, "a variant has to be a table of " + join(kKeys));
  for (const auto& [key, value] : *keys) {
    if (std::ranges::find(kKeys, key) != kKeys.end()) continue;
    refuse(what, "a variant has '" + key + "', allowed are: " + join(kKeys));
  }
  VariantDefinition definition;
  definition.id = text_of(document, "id", true, what);
  definition.base = text_of(document, "base", true, what);
  definition.instruction = text_of(document, "instruction", false, what);
  if (const Document* constants = find(document, "constants")) {
    const auto* table = std::get_if<DocumentTable>(&constants->value);
    if (table == nullptr)
      refuse(what, "the constants of '" + definition.id + "' have to be a table");
    definition.constants = *table;
  }
  return definition;
}

void load_variants(const std::filesystem::path& file) {
  const std::string what = "variants of '" + file.string() + "'";
  const std::optional<std::string> text = read_input(file);
  if (!text)
    throw Error(Error::kIo, "'" + file.string() + "' cannot be read; a file of variants needed");
  const std::optional<Document> document = parse_document(*text);
  if (!document) refuse(what, "not JSON");
  try {
    register_variants(definitions_of(*document, what));
  } catch (const Error& error) {
    if (std::string_view(error.what()).starts_with(what)) throw;
    throw Error(error.kind(), what + ": " + error.what());
  }
}

void load_environment_variants() {
  static std::once_flag once;
  std::call_once(once, [] {
    const char* file = std::getenv(kFileVariable);
    if (file != nullptr && *file != '\0') load_variants(file);
  });
}

Document changes_document(const RegistryEntry& entry, const ConstantTable& changes) {
  const ConstantTable all =
      entry.constants == nullptr ? changes : overridden(*entry.constants, changes);
  if (all.empty() && entry.constants == nullptr) return nullptr;
  return DocumentTable{{"base", entry.base}, {"constants", all}};
}

}  // namespace engram
