// Owning handles of MuJoCo's objects, and a guard of its process-wide error handlers.
#pragma once

#include <mujoco/mujoco.h>

#include <cstddef>
#include <memory>
#include <string>

namespace engram {

struct ModelDeleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
// Frees memory that mmap returned.
struct PageDeleter {
  std::size_t bytes = 0;
  void operator()(std::byte* pages) const noexcept;
};
struct DataDeleter {
  std::unique_ptr<std::byte, PageDeleter> contact_memory = nullptr;  // if contacts lie apart
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using ModelPtr = std::unique_ptr<mjModel, ModelDeleter>;
using DataPtr = std::unique_ptr<mjData, DataDeleter>;

// Compiles an MJCF text. Throws Error with MuJoCo's message if it is refused.
ModelPtr compile_model(const std::string& mjcf);

// Throws Error if memory runs out.
DataPtr make_data(const mjModel& model);

// Makes mjData whose arrays of contacts and constraints lie apart, in pages that take up memory
// only once they are written. MuJoCo allocates and clears arrays for the largest possible number of
// constraints, and for its square. Not for mj_copyData.
DataPtr make_data_lazy_contacts(const mjModel& model);

// RAII guard: while it lives on a thread, MuJoCo's errors on that thread become exceptions of type
// Error, and its warnings are silent (mjData::warning counts them). Other threads keep the
// behaviour that their program has chosen, so that engram can live beside other users of MuJoCo.
class MujocoScope {
 public:
  MujocoScope();
  ~MujocoScope();
  MujocoScope(const MujocoScope&) = delete;
  MujocoScope& operator=(const MujocoScope&) = delete;
};

}  // namespace engram
