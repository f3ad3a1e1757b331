// The rules of a custom task, behind one interface: callbacks of a program, or another
// process.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "core/base/field.h"
#include "tasks/custom/description.h"

namespace engram::tasks {

// Methods of a task. The numbers are those of the C API.
enum class CustomMethod {
  kReset,
  kBeforePhysics,
  kAdvance,
  kEvaluate,
  kReward,
  kObserve,
  kOracle,
  kBlind,
  kSweep,
};

// One column as the rules see it.
struct CustomArray {
  Field field;
  std::byte* all = nullptr;             // rows of all environments
  std::byte* subset_rows = nullptr;     // as many spare rows
  bool is_written = false;              // what the rules write there counts
  std::shared_ptr<void> memory_of_all;  // keep the rows for those that may outlive the batch
  std::shared_ptr<void> memory_of_some;

  std::size_t row_bytes() const {
    return static_cast<std::size_t>(field.width) * size_of(field.dtype);
  }
};

// The rules of one task of one batch. Calls may throw Error.
class CustomInstance {
 public:
  virtual ~CustomInstance() = default;

  virtual const CustomDescription& description() const = 0;
  // Memory for spare rows, aligned to 64 bytes; null: anywhere.
  virtual std::shared_ptr<std::byte> spare_memory(std::size_t /*bytes*/) { return nullptr; }
  // True if it can work on the rows of all environments where they are.
  virtual bool sees_batch() const { return true; }
  // Called once, before call().
  virtual void bind(std::span<const CustomArray> arrays, int num_envs) = 0;
  // Works on the rows of all environments, or on the first `rows` spare ones.
  virtual void call(CustomMethod method, int rows, bool of_all) = 0;
};

// Makes instances; may be called from any thread.
class CustomFactory {
 public:
  virtual ~CustomFactory() = default;
  // constants: the values of all constants.
  virtual std::unique_ptr<CustomInstance> make(const std::string& id,
                                               const ConstantTable& constants) const = 0;
};

}  // namespace engram::tasks
