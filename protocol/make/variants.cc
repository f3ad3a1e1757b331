#include "protocol/make/variants.h"

#include <algorithm>
#include <array>
#include <vector>

#include "core/base/error.h"
#include "core/base/join.h"
#include "protocol/io/files.h"

namespace engram {
namespace {

constexpr std::array kKeys = {"id", "base", "constants", "instruction"};

[[noreturn]] void refuse(std::string_view what, const std::string& why) {
  throw Error(Error::kInvalidArgument, std::string(what) + ": " + why);
}

// Returns the text under a key; "" where the key is missing and need not be there.
std::string text_of(const Json& document, const char* key, bool needed, std::string_view what) {
  const Json* found = find(document, key);
  if (found == nullptr && !needed) return "";
  const auto* value = found == nullptr ? nullptr : std::get_if<std::string>(&found->value);
  if (value == nullptr) refuse(what, std::string("a text '") + key + "' needed");
  return *value;
}

std::vector<TaskVariant> variants_in(const Json& document, const std::string& what) {
  const Json* variants = find(document, "variants");
  const auto* list = variants == nullptr ? nullptr : std::get_if<JsonList>(&variants->value);
  if (list == nullptr) refuse(what, R"(not of the form {"variants": [...]})");
  std::vector<TaskVariant> all;
  for (const Json& one : *list) all.push_back(to_variant(one, what));
  return all;
}

}  // namespace

ConstantTable parse_constants(std::string_view json) {
  std::optional<Json> document = parse_json(json);
  auto* table = document ? std::get_if<JsonTable>(&document->value) : nullptr;
  if (table == nullptr) {
    refuse("constants",
           "'" + std::string(json) + R"(' given, a JSON object such as {"COLORS": 7} needed)");
  }
  return std::move(*table);
}

Json to_document(const TaskVariant& variant) {
  JsonTable table = {{"id", variant.id}, {"base", variant.base}, {"constants", variant.constants}};
  if (!variant.instruction.empty()) table.emplace_back("instruction", variant.instruction);
  return table;
}

TaskVariant to_variant(const Json& document, std::string_view what) {
  const auto* keys = std::get_if<JsonTable>(&document.value);
  if (keys == nullptr) refuse(what, "a variant has to be a table of " + join(kKeys));
  for (const auto& [key, value] : *keys) {
    if (std::ranges::find(kKeys, key) != kKeys.end()) continue;
    refuse(what, "a variant has '" + key + "', allowed are: " + join(kKeys));
  }
  TaskVariant variant;
  variant.id = text_of(document, "id", true, what);
  variant.base = text_of(document, "base", true, what);
  variant.instruction = text_of(document, "instruction", false, what);
  if (const Json* constants = find(document, "constants")) {
    const auto* table = std::get_if<JsonTable>(&constants->value);
    if (table == nullptr) refuse(what, "the constants of '" + variant.id + "' have to be a table");
    variant.constants = *table;
  }
  return variant;
}

void load_variants(const std::filesystem::path& file) {
  const std::string what = "variants of '" + file.string() + "'";
  const std::optional<std::string> text = read_input(file);
  if (!text)
    throw Error(Error::kIo, "'" + file.string() + "' cannot be read; a file of variants needed");
  const std::optional<Json> document = parse_json(*text);
  if (!document) refuse(what, "not JSON");
  try {
    register_variants(variants_in(*document, what));
  } catch (const Error& error) {
    if (std::string_view(error.what()).starts_with(what)) throw;
    throw Error(error.kind(), what + ": " + error.what());
  }
}

Json variant_document(const RegistryEntry& entry, const ConstantTable& constants) {
  const ConstantTable all =
      entry.constants == nullptr ? constants : merge_constants(*entry.constants, constants);
  if (all.empty() && entry.constants == nullptr) return nullptr;
  return JsonTable{{"base", entry.base}, {"constants", all}};
}

}  // namespace engram
