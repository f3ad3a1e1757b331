// Ownership of MuJoCo's objects; its process-wide handlers, kept from harming other users.
#pragma once

#include <mujoco/mujoco.h>

#include <cstddef>
#include <memory>
#include <string>

namespace engram {

struct ModelDeleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
// Frees memory that came straight from the system.
struct PageDeleter {
  std::size_t bytes = 0;
  void operator()(std::byte* pages) const noexcept;
};
struct DataDeleter {
  std::unique_ptr<std::byte, PageDeleter> room = nullptr;  // for contacts, if they lie apart
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using ModelPtr = std::unique_ptr<mjModel, ModelDeleter>;
using DataPtr = std::unique_ptr<mjData, DataDeleter>;

// Compiles an MJCF text. Throws Error with MuJoCo's message if it is refused.
ModelPtr compile_model(const std::string& mjcf);

// Throws Error if memory runs out.
DataPtr make_data(const mjModel& model);

// The same, but what contacts and constraints need lies apart, in memory that takes up no room
// before it is first written. MuJoCo makes and clears room for as many as there may ever be, the
// square of their number included. Not for mj_copyData.
DataPtr make_data_lazy_contacts(const mjModel& model);

// While one lives on a thread, errors of MuJoCo on that thread become exceptions of type Error and
// its warnings are silent (they stay countable in mjData::warning). Other threads keep the
// behaviour that their program has chosen, so that engram can live beside other users of MuJoCo.
class MujocoScope {
 public:
  MujocoScope();
  ~MujocoScope();
  MujocoScope(const MujocoScope&) = delete;
  MujocoScope& operator=(const MujocoScope&) = delete;
};

}  // namespace engram
