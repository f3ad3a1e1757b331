#include "api/c_batch.h"

#include <algorithm>

namespace engram::c {

std::int32_t dtype_of(DType type) {
  switch (type) {
    case DType::kBool:
      return ENGRAM_BOOL;
    case DType::kInt32:
      return ENGRAM_INT32;
    case DType::kUInt64:
      return ENGRAM_UINT64;
    case DType::kFloat32:
      return ENGRAM_FLOAT32;
    case DType::kFloat64:
      return ENGRAM_FLOAT64;
    case DType::kUInt8:
      return ENGRAM_UINT8;
    case DType::kInt16:
      return ENGRAM_INT16;
  }
  return ENGRAM_UINT8;
}

engram_array to_array(const OutputArray& output) {
  const Field& field = output.field;
  engram_array array{};
  array.name = field.name.c_str();
  array.unit = field.unit.c_str();
  array.description = field.description.c_str();
  array.data = output.data;
  array.dtype = dtype_of(field.dtype);
  array.ndim = static_cast<std::int32_t>(output.shape.size());
  std::ranges::copy(output.shape, array.shape);
  return array;
}

engram_status refuse_null(const char* what) noexcept {
  return guarded([what] {
    throw Error(Error::kInvalidArgument, std::string(what) + ": NULL given, an address needed");
  });
}

engram_status refuse_busy(CallState found) noexcept {
  return fail(ENGRAM_BAD_STATE, found == CallState::kStepping
                                    ? "a step is under way; wait for it first"
                                    : "this batch is at work in another thread; use it from one "
                                      "thread at a time");
}

engram_status refuse_forked(const engram_env& env) noexcept {
  return guarded([&env] {
    throw Error(Error::kBadState,
                "this batch was made in process " + std::to_string(env.owner) +
                    ", whose threads do not survive a fork; make one in process " +
                    std::to_string(::getpid()));
  });
}

}  // namespace engram::c

engram_env::engram_env(std::unique_ptr<engram::Batch> made)
    : batch(std::move(made)),
      queries(*batch),
      renderer(*batch),
      snapshotter(*batch),
      actions(static_cast<std::size_t>(batch->num_envs()) *
              static_cast<std::size_t>(batch->action_dim())) {}

std::span<const float> engram_env::copied(std::span<const float> given) {
  if (given.size() != actions.size()) return given;
  std::ranges::copy(given, actions.begin());
  return actions;
}
