#include "core/scene/mujoco_memory.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace engram {
namespace {

std::uintptr_t page_size() { return static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE)); }

// Bytes of the pages in memory that a range touches.
std::size_t pages_in_memory(const void* begin, std::size_t bytes) {
  if (bytes == 0) return 0;
  const std::uintptr_t page = page_size();
  const auto start = reinterpret_cast<std::uintptr_t>(begin);
  const std::uintptr_t first = start / page * page;
  std::vector<unsigned char> present((start + bytes - first + page - 1) / page);
  if (mincore(reinterpret_cast<void*>(first), present.size() * page, present.data()) != 0) {
    return bytes;
  }
  const auto count = std::count_if(present.begin(), present.end(),
                                   [](unsigned char one) { return (one & 1) != 0; });
  return page * static_cast<std::size_t>(count);
}

#if mjVERSION_HEADER < 300
std::size_t stack_bytes(const mjData& data) {
  return sizeof(mjtNum) * static_cast<std::size_t>(data.nstack);
}
#endif

}  // namespace

#if mjVERSION_HEADER >= 300

MujocoWorkspace::MujocoWorkspace(const mjModel& /*model*/) {}
WorkspaceLoan::WorkspaceLoan(mjData& data, MujocoWorkspace& /*workspace*/)
    : data_(data), stack_(nullptr), jacobian_(nullptr), columns_(nullptr) {}
void WorkspaceLoan::exchange() {}
void release_stack(mjData& /*data*/) {}

#else

MujocoWorkspace::MujocoWorkspace(const mjModel& model) {
  const auto entries = static_cast<std::size_t>(model.nv) * static_cast<std::size_t>(model.njmax);
  stack_ = std::make_unique_for_overwrite<mjtNum[]>(static_cast<std::size_t>(model.nstack));
  jacobian_ = std::make_unique_for_overwrite<mjtNum[]>(entries);
  columns_ = std::make_unique_for_overwrite<int[]>(entries);
}

WorkspaceLoan::WorkspaceLoan(mjData& data, MujocoWorkspace& workspace)
    : data_(data),
      stack_(workspace.stack_.get()),
      jacobian_(workspace.jacobian_.get()),
      columns_(workspace.columns_.get()) {
  exchange();
}

void WorkspaceLoan::exchange() {
  std::swap(data_.stack, stack_);
  std::swap(data_.efc_JT, jacobian_);
  std::swap(data_.efc_JT_colind, columns_);
}

void release_stack(mjData& data) {
  const std::uintptr_t page = page_size();
  const auto start = reinterpret_cast<std::uintptr_t>(data.stack);
  const std::uintptr_t first = (start + page - 1) / page * page;
  const std::uintptr_t end = (start + stack_bytes(data)) / page * page;
  if (first < end) madvise(reinterpret_cast<void*>(first), end - first, MADV_DONTNEED);
}

#endif

std::size_t resident_bytes(const DataPtr& data) {
  const auto& contacts = data.get_deleter().contact_memory;
  std::size_t bytes =
      sizeof *data + pages_in_memory(data->buffer, static_cast<std::size_t>(data->nbuffer));
  if (contacts) bytes += pages_in_memory(contacts.get(), contacts.get_deleter().bytes);
#if mjVERSION_HEADER >= 300
  return bytes + pages_in_memory(data->arena, static_cast<std::size_t>(data->narena));
#else
  return bytes + pages_in_memory(data->stack, stack_bytes(*data));
#endif
}

}  // namespace engram
