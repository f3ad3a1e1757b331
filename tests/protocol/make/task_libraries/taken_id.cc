// A library with a free id, and one that a task of the benchmark has.
#include <stdexcept>

#include "core/task/task.h"
#include "tasks/task_library.h"

namespace {

constexpr engram::TaskSpec kFree[] = {{"FreeId-VLA-v0", 30, engram::Split::kExtended}};
constexpr engram::TaskSpec kTaken[] = {{"RememberColor9-VLA-v0", 30, engram::Split::kExtended}};

std::unique_ptr<engram::Task> make(const engram::RegistryEntry&, const engram::ConstantTable&) {
  throw std::runtime_error("never made");
}

constexpr engram::Family kFreeFamily = {
    .name = "FreeId", .memory_type = "Spatial", .tasks = kFree, .make = make};
constexpr engram::Family kTakenFamily = {
    .name = "RememberColor", .memory_type = "Spatial", .tasks = kTaken, .make = make};

}  // namespace

ENGRAM_TASKS(kFreeFamily, kTakenFamily);
