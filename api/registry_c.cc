// The C API of the registry: ids of tasks, variants, libraries of tasks.
#include <algorithm>
#include <map>
#include <mutex>
#include <set>
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

using Descriptions = std::map<const engram::RegistryEntry*, engram::Json>;

// The newest list of tasks, and the texts of all: callers hold earlier ones.
struct TaskLists {
  Descriptions tasks;
  const std::string* newest = nullptr;
  std::set<std::string> texts;

  bool is_of(const std::vector<const engram::RegistryEntry*>& entries) const {
    return newest != nullptr && tasks.size() == entries.size() &&
           std::ranges::all_of(entries, [&](const auto* entry) { return tasks.contains(entry); });
  }
};

// All tasks as JSON. A new list is made when other tasks are registered. Describing a task makes
// it, which may run a user's code: without the lock.
const char* list_of_tasks() {
  static TaskLists lists;
  std::mutex& mutex = engram::process_mutex(engram::ProcessLock::kTaskTexts);
  const std::vector<const engram::RegistryEntry*> entries = engram::all_entries();
  Descriptions known;
  {
    const std::lock_guard lock(mutex);
    if (lists.is_of(entries)) return lists.newest->c_str();
    known = lists.tasks;
  }
  engram::ConstantList list;
  Descriptions tasks;
  for (const engram::RegistryEntry* entry : entries) {
    const auto found = known.find(entry);
    engram::Json task = found == known.end() ? engram::describe_entry(*entry) : found->second;
    list.push_back(task);
    tasks.emplace(entry, std::move(task));
  }
  std::string text = engram::to_text(list);
  const std::lock_guard lock(mutex);
  lists.newest = &*lists.texts.insert(std::move(text)).first;
  lists.tasks.swap(tasks);
  return lists.newest->c_str();
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
