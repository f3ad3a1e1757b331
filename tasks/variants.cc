#include "tasks/variants.h"

#include <algorithm>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/ieee_scope.h"
#include "core/base/process_mutex.h"
#include "core/env/task.h"

namespace engram {
namespace {

constexpr std::size_t kLongestId = 100;

struct Variant {
  VariantDefinition definition;
  RegistryEntry entry;
};

// Variants never move: entries and texts are pointed to. Empty, the list needs no memory.
using List = std::vector<std::unique_ptr<Variant>>;

// Used under ProcessLock::kVariants.
List& variants() {
  static List all;
  return all;
}

// name-vN, as Gymnasium wants it.
bool is_id(std::string_view id) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto is_part = [&](char c) {
    return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' ||
           c == '_' || c == '.';
  };
  const std::size_t version = id.rfind("-v");
  return version != std::string_view::npos && version > 0 && id.size() <= kLongestId &&
         id.size() > version + 2 && std::ranges::all_of(id, is_part) &&
         std::ranges::all_of(id.substr(version + 2), is_digit);
}

// The same, on one of the benchmark's tasks.
VariantDefinition flattened(VariantDefinition definition, const RegistryEntry& base) {
  definition.base = base.base;
  if (base.constants != nullptr) {
    definition.constants = overridden(*base.constants, definition.constants);
  }
  if (definition.instruction.empty()) definition.instruction = base.instruction;
  return definition;
}

// As the task has them: a whole number stays one where 7.0 was given.
void take_values(const TaskInfo& info, ConstantTable& constants) {
  for (auto& [name, value] : constants) {
    value = std::ranges::find(info.constants, name, &TaskConstant::name)->value;
  }
}

}  // namespace

ConstantTable overridden(const ConstantTable& constants, const ConstantTable& changes) {
  ConstantTable all = constants;
  for (const auto& [name, value] : changes) {
    const auto found = std::ranges::find(all, name, [](const auto& one) { return one.first; });
    if (found == all.end()) {
      all.emplace_back(name, value);
    } else {
      found->second = value;
    }
  }
  return all;
}

namespace {

// Variants that are about to be registered, all of them or none.
class VariantBatch {
 public:
  void add(const VariantDefinition& definition) {
    const std::string& id = definition.id;
    if (!is_id(id)) {
      throw Error(Error::kInvalidArgument,
                  "id of a variant: '" + id +
                      "' given, letters, digits and '-_.' that end in -v and " +
                      "a number allowed, at most " + std::to_string(kLongestId));
    }
    const RegistryEntry& base = base_of(definition);
    VariantDefinition own = flattened(definition, base);
    const std::unique_ptr<Task> task = base.definition->make(base, own.constants);
    take_values(task->info(), own.constants);
    if (is_there(own)) return;
    list_.push_back(std::make_unique<Variant>());
    Variant& variant = *list_.back();
    variant.definition = std::move(own);
    variant.entry = base;
    variant.entry.id = variant.definition.id;
    variant.entry.horizon = task->info().horizon;
    variant.entry.canonical = false;
    variant.entry.instruction = variant.definition.instruction;
    variant.entry.constants = &variant.definition.constants;
  }

  // All are in the list, or an exception leaves it as it was.
  void commit(List& list) {
    list.reserve(list.size() + list_.size());
    for (std::unique_ptr<Variant>& variant : list_) {
      variant->entry.index = static_cast<int>(registry().size() + list.size());
      list.push_back(std::move(variant));
    }
  }

 private:
  const RegistryEntry& base_of(const VariantDefinition& definition) const {
    const auto own = std::ranges::find(list_, definition.base,
                                       [](const auto& one) { return one->definition.id; });
    return own == list_.end() ? require_entry(definition.base) : (*own)->entry;
  }

  // Whether the same variant is registered already. Throws Error if another has its id.
  bool is_there(const VariantDefinition& own) const {
    const auto added =
        std::ranges::find(list_, own.id, [](const auto& one) { return one->definition.id; });
    const RegistryEntry* taken = added == list_.end() ? find_entry(own.id) : &(*added)->entry;
    if (taken == nullptr) return false;
    if (taken->constants != nullptr && definition_of(*taken) == own) return true;
    throw Error(Error::kInvalidArgument,
                "id '" + own.id + "' is taken, by " +
                    (taken->constants == nullptr ? "a task of the benchmark"
                                                 : "a variant that is defined in another way") +
                    "; another id needed");
  }

  List list_;
};

}  // namespace

void register_variants(std::span<const VariantDefinition> definitions) {
  // Held from the look whether an id is free to its registration.
  const std::scoped_lock one_at_a_time(process_mutex(ProcessLock::kRegistering));
  const IeeeScope scope;
  VariantBatch batch;
  for (const VariantDefinition& definition : definitions) batch.add(definition);
  const std::scoped_lock lock(process_mutex(ProcessLock::kVariants));
  batch.commit(variants());
}

const RegistryEntry* find_variant_entry(std::string_view id) noexcept {
  const List& all = variants();
  const std::scoped_lock lock(process_mutex(ProcessLock::kVariants));
  const auto found = std::ranges::find(all, id, [](const auto& one) { return one->entry.id; });
  return found == all.end() ? nullptr : &(*found)->entry;
}

std::vector<const RegistryEntry*> all_entries() {
  std::vector<const RegistryEntry*> entries;
  for (const RegistryEntry& entry : registry()) entries.push_back(&entry);
  const List& all = variants();
  const std::scoped_lock lock(process_mutex(ProcessLock::kVariants));
  for (const auto& variant : all) entries.push_back(&variant->entry);
  return entries;
}

const RegistryEntry& entry_at(int index) {
  const auto place = static_cast<std::size_t>(index);
  if (place < registry().size()) return registry()[place];
  const List& all = variants();
  const std::scoped_lock lock(process_mutex(ProcessLock::kVariants));
  return all.at(place - registry().size())->entry;
}

VariantDefinition definition_of(const RegistryEntry& entry) {
  if (entry.constants == nullptr) return {std::string(entry.id), std::string(entry.id), {}, {}};
  return {std::string(entry.id), std::string(entry.base), *entry.constants,
          std::string(entry.instruction)};
}

}  // namespace engram
