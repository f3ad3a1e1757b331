// The C API of the registry: ids of tasks, variants, libraries of tasks.
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "api/c_batch.h"
#include "api/c_error.h"
#include "core/threads/process_mutex.h"
#include "engram/engram_c.h"
#include "protocol/make/environment_files.h"
#include "protocol/make/task_description.h"
#include "protocol/make/task_library.h"
#include "protocol/make/variants.h"

namespace {

using engram::Error;
using engram::c::guarded;
using engram::c::refuse_null;

// All tasks as JSON. Earlier lists stay, since callers hold them; a new one is made when other
// tasks are registered. Describing a task makes it, which may run a user's code: without the lock.
const char* list_of_tasks() {
  using Entries = std::vector<const engram::RegistryEntry*>;
  using Descriptions = std::map<const engram::RegistryEntry*, engram::Json>;
  static Descriptions described;
  static std::map<Entries, std::string> lists;
  std::mutex& mutex = engram::process_mutex(engram::ProcessLock::kTaskTexts);
  const Entries entries = engram::all_entries();
  Descriptions known;
  {
    const std::lock_guard lock(mutex);
    const auto found = lists.find(entries);
    if (found != lists.end()) return found->second.c_str();
    known = described;
  }
  engram::ConstantList tasks;
  for (const engram::RegistryEntry* entry : entries) {
    auto found = known.find(entry);
    if (found == known.end()) found = known.emplace(entry, engram::describe_entry(*entry)).first;
    tasks.push_back(found->second);
  }
  std::string text = engram::to_text(tasks);
  const std::lock_guard lock(mutex);
  const char* list = lists.emplace(entries, std::move(text)).first->second.c_str();
  described.swap(known);
  return list;
}

}  // namespace

size_t engram_num_tasks() {
  size_t count = 0;
  guarded([&count] {
    engram::load_environment_files();
    count = engram::all_entries().size();
  });
  return count;
}

const char* engram_task_id(size_t index) {
  const char* id = nullptr;
  guarded([&] {
    engram::load_environment_files();
    const size_t count = engram::all_entries().size();
    if (index >= count) {
      throw Error(Error::kInvalidArgument, "task " + std::to_string(index) + " given, 0 to " +
                                               std::to_string(count - 1) + " allowed");
    }
    id = engram::entry_at(static_cast<int>(index)).id.data();  // closed by a 0
  });
  return id;
}

const char* engram_list_json() {
  const char* text = nullptr;
  guarded([&text] {
    engram::load_environment_files();
    text = list_of_tasks();
  });
  return text;
}

engram_status engram_register_variant(const char* id, const char* base, const char* constants,
                                      const char* instruction) {
  if (id == nullptr) return refuse_null("id");
  if (base == nullptr) return refuse_null("base");
  return guarded([&] {
    engram::load_environment_files();
    engram::TaskVariant variant{id, base};
    if (constants != nullptr) variant.constants = engram::parse_constants(constants);
    if (instruction != nullptr) variant.instruction = instruction;
    engram::register_variants({&variant, 1});
  });
}

engram_status engram_load_variants(const char* path) {
  if (path == nullptr) return refuse_null("path");
  return guarded([&] { engram::load_variants(path); });
}

engram_status engram_load_tasks(const char* path) {
  if (path == nullptr) return refuse_null("path");
  return guarded([&] { engram::load_tasks(path); });
}
