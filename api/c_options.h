// Conversions from the plain structs of the C API to the engine's own, which refuse values that
// those cannot hold.
#pragma once

#include <cstdint>
#include <vector>

#include "core/batch/reset_request.h"
#include "engram/engram_c.h"
#include "protocol/make/make.h"

namespace engram::c {

engram_options default_options() noexcept;

// Throws Error for values that MakeOptions cannot hold; make() checks the rest.
MakeOptions to_make_options(const engram_options& options);

std::vector<TaskOptionValue> to_choices(const engram_task_option* choices, std::size_t count);
std::vector<PerturbationLevel> to_perturbations(const engram_perturbation* perturbations,
                                                std::size_t count);

std::vector<Pin> to_pins(const engram_pin* pins, std::size_t count);

// Arguments of a reset. Throws Error for pins and constants that the engine cannot hold.
class GivenReset {
 public:
  // request: NULL: all environments, seeds and pins as before.
  GivenReset(const engram_reset_request* request, int num_envs);
  GivenReset(const GivenReset&) = delete;
  GivenReset& operator=(const GivenReset&) = delete;

  // Points to this object, and to the caller's arrays.
  const ResetRequest& request() const noexcept { return request_; }

 private:
  ResetRequest request_;
  std::vector<Pin> pins_;
  ConstantTable constants_;
};

Policy to_policy(std::int32_t policy);

TaskShare to_share(const engram_task_share& share);
// count targets of each turn.
std::vector<std::vector<OutputTarget>> to_turns(const engram_output_target* targets,
                                                std::size_t turns, std::size_t count);

}  // namespace engram::c
