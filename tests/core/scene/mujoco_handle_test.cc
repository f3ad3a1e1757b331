#include "core/scene/mujoco_handle.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdint>
#include <exception>
#include <string>
#include <thread>

#include "core/base/error.h"
#include "tests/allocation_counter.h"

namespace engram {
namespace {

// Takes numbers from the stack of the data.
#if mjVERSION_HEADER >= 300
constexpr auto* allocate = &mj_stackAllocNum;
#else
constexpr auto* allocate = &mj_stackAlloc;
#endif

// More numbers than a stack or an arena has.
constexpr int kTooMany = 100'000'000;

constexpr const char* kBall =
    "<mujoco><size nstack='1000'/><worldbody><body><freejoint/><geom size='1' mass='1'/></body>"
    "</worldbody></mujoco>";

TEST_CASE("A scene that MuJoCo refuses becomes an Error with its message", "[mujoco]") {
  CHECK_THROWS_WITH(compile_model("<mujoco><worldbody><body><geom/></body></worldbody></mujoco>"),
                    Catch::Contains("scene refused by MuJoCo") && Catch::Contains("size"));
  CHECK_THROWS_AS(compile_model("not xml at all"), Error);
  CHECK_THROWS_AS(compile_model(""), Error);
}

TEST_CASE("A scene that there is no memory for leaves no copy of its text",
          "[mujoco][allocation]") {
  (void)compile_model(kBall);  // what MuJoCo makes once for the whole process
  const test::MujocoMemory counted;
  // The copy itself, then the first objects of the parser, which loses some of the later ones.
  constexpr std::int64_t kKept = mjVERSION_HEADER < 300 ? 7 : 2;
  for (std::int64_t number = 1; number <= kKept; ++number) {
    const std::int64_t before = test::outstanding_allocations();
    bool compiled = false;
    {
      const test::FailingAllocation failing(number);
      try {
        (void)compile_model(kBall);
        compiled = true;
      } catch (const std::exception&) {
      }
    }
    const std::int64_t left = test::outstanding_allocations() - before;  // INFO allocates
    INFO("allocation " << number);
    CHECK(!compiled);
    CHECK(left == 0);
  }
}

TEST_CASE("A scene of any length is compiled", "[mujoco]") {
  std::string text = "<mujoco><worldbody>";
  for (int i = 0; i < 2000; ++i) text += "<geom type='sphere' size='0.1'/>";
  const ModelPtr model = compile_model(text + "</worldbody></mujoco>");
  CHECK(model->ngeom == 2000);
}

TEST_CASE("An error of MuJoCo inside a scope is an Error and nothing is lost", "[mujoco]") {
  const ModelPtr model = compile_model(kBall);
  const DataPtr data = make_data(*model);
  const MujocoScope scope;
  try {
    allocate(data.get(), kTooMany);
    FAIL("no error");
  } catch (const Error& error) {
    CHECK(error.kind() == Error::kInternal);
    CHECK_THAT(error.what(), Catch::StartsWith("MuJoCo: ") && Catch::Contains("tack overflow"));
  }
  mj_resetData(model.get(), data.get());
  mj_step(model.get(), data.get());
  CHECK(data->time > 0);
}

TEST_CASE("Sparing data computes what MuJoCo's own does, and again after a reset", "[mujoco]") {
  const ModelPtr model = compile_model(
      "<mujoco><option cone='elliptic'/><size nstack='20000' nconmax='30' njmax='120'/><worldbody>"
      "<geom name='floor' type='plane' size='1 1 1'/>"
      "<body pos='0 0 0.1'><freejoint/>"
      "<geom name='low' type='box' size='.1 .1 .1' mass='1'/></body>"
      "<body pos='.05 0 0.32'><freejoint/>"
      "<geom name='high' type='box' size='.1 .1 .1' mass='1'/></body>"
      "</worldbody><contact><pair geom1='floor' geom2='low'/><pair geom1='low' geom2='high'/>"
      "</contact></mujoco>");
  const DataPtr usual = make_data(*model);
  const DataPtr sparing = make_data_lazy_contacts(*model);
  for (int episode = 0; episode < 2; ++episode) {
    for (int i = 0; i < 50; ++i) {
      mj_step(model.get(), usual.get());
      mj_step(model.get(), sparing.get());
      REQUIRE(std::equal(usual->qpos, usual->qpos + model->nq, sparing->qpos));
      REQUIRE(std::equal(usual->qvel, usual->qvel + model->nv, sparing->qvel));
    }
    CHECK(usual->ncon > 0);
    CHECK(sparing->ncon == usual->ncon);
    CHECK(sparing->nefc == usual->nefc);
    mj_resetData(model.get(), usual.get());
    mj_resetData(model.get(), sparing.get());
  }
  CHECK(reinterpret_cast<std::uintptr_t>(sparing->contact) % 64 == 0);
  if (mjVERSION_HEADER < 300) CHECK(sparing->nbuffer < usual->nbuffer);
}

TEST_CASE("Inside a scope warnings are counted and not shown", "[mujoco]") {
  const ModelPtr model = compile_model(kBall);
  const DataPtr data = make_data(*model);
  const MujocoScope scope;
  mj_warning(data.get(), mjWARN_BADQPOS, 3);
  CHECK(data->warning[mjWARN_BADQPOS].number == 1);
}

TEST_CASE("Scopes nest", "[mujoco]") {
  const ModelPtr model = compile_model(kBall);
  const DataPtr data = make_data(*model);
  const MujocoScope outer;
  { const MujocoScope inner; }
  CHECK_THROWS_AS(allocate(data.get(), kTooMany), Error);
}

std::atomic<int> foreign_warnings = 0;
std::atomic<int> foreign_errors = 0;

TEST_CASE("Another thread keeps the handlers of its program while a scope is open", "[mujoco]") {
  const ModelPtr model = compile_model(kBall);  // engram's handlers are in place from here on
  const DataPtr data = make_data(*model);
  const auto before_warning = mju_user_warning;
  const auto before_error = mju_user_error;
  // A program that sets its own handlers later has them.
  mju_user_warning = [](const char*) { ++foreign_warnings; };
  mju_user_error = [](const char*) {
    ++foreign_errors;
    throw 1;  // must not return
  };
  std::thread([&] {
    mj_warning(data.get(), mjWARN_BADQPOS, 3);
    try {
      allocate(data.get(), kTooMany);
    } catch (int) {
    }
  }).join();
  mju_user_warning = before_warning;
  mju_user_error = before_error;
  CHECK(foreign_warnings == 1);
  CHECK(foreign_errors == 1);
}

}  // namespace
}  // namespace engram
