#include "core/scene/mujoco_memory.h"

#include <mujoco/mjxmacro.h>
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
    : data_(data), workspace_(nullptr) {}
void WorkspaceLoan::exchange() {}
void release_stack(mjData& /*data*/) {}

#else

MujocoWorkspace::MujocoWorkspace(const mjModel& model) : data_(make_data_lazy_contacts(model)) {}

WorkspaceLoan::WorkspaceLoan(mjData& data, MujocoWorkspace& workspace)
    : data_(data), workspace_(workspace.data_.get()) {
  exchange();
}

void WorkspaceLoan::exchange() {
  const auto swap_inputs = [this] {
    std::swap(data_.qpos, workspace_->qpos);
    std::swap(data_.qvel, workspace_->qvel);
    std::swap(data_.act, workspace_->act);
    std::swap(data_.qacc_warmstart, workspace_->qacc_warmstart);
    std::swap(data_.ctrl, workspace_->ctrl);
    std::swap(data_.qfrc_applied, workspace_->qfrc_applied);
    std::swap(data_.xfrc_applied, workspace_->xfrc_applied);
    std::swap(data_.mocap_pos, workspace_->mocap_pos);
    std::swap(data_.mocap_quat, workspace_->mocap_quat);
  };
  std::swap(data_.stack, workspace_->stack);
#define X(type, name, rows, columns) std::swap(data_.name, workspace_->name);
  MJDATA_POINTERS
#undef X
  swap_inputs();  // once more: they are back
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
