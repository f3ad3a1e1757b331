// Working memory that mjData share.
#include "core/scene/mujoco_memory.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "tests/core/scene/props.h"

namespace engram::test {
namespace {

std::vector<mjtNum> positions_after(mjData& data, const mjModel& model, int steps) {
  const MujocoScope scope;
  for (int i = 0; i < steps; ++i) mj_step(&model, &data);
  return {data.qpos, data.qpos + model.nq};
}

}  // namespace

TEST_CASE("A borrowed workspace changes no bit and is given back", "[mujoco_memory]") {
  const mjModel& model = mixed_model().full();
  const DataPtr alone = make_data_lazy_contacts(model);
  const DataPtr borrower = make_data_lazy_contacts(model);
  release_stack(*alone);
  release_stack(*borrower);
  const std::size_t before = resident_bytes(borrower);
  MujocoWorkspace workspace(model);
  std::vector<mjtNum> borrowed;
  {
    const WorkspaceLoan loan(*borrower, workspace);
    borrowed = positions_after(*borrower, model, 20);
  }
  CHECK(borrowed == positions_after(*alone, model, 20));
  CHECK(resident_bytes(borrower) >= before);
  if (mjVERSION_HEADER < 300) CHECK(resident_bytes(borrower) < resident_bytes(alone));
  CHECK(positions_after(*borrower, model, 20) == positions_after(*alone, model, 20));
}

}  // namespace engram::test
