// Bits are equal on processors without fused multiplication, and with older vectors. The C library
// is made to believe that it runs on one: it then computes sines and the like in another way.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>

#include "core/base/checksum.h"
#include "core/batch/queries.h"
#include "protocol/make/make.h"
#include "tests/env_helpers.h"
#include "tests/own_process.h"

namespace engram {
namespace {

// Names of glibc 2.33 and later, and those of before.
constexpr const char* kOldProcessor =
    "GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F,-AVX2_Usable,-FMA_Usable,"
    "-AVX512F_Usable";

// Everything about a task: its scene, compiled, and what a batch shows and remembers after some
// steps.
std::uint64_t bits_of(std::string_view id) {
  constexpr int kSteps = 12;
  const BatchOptions options{.num_envs = 2, .threads = 1, .obs_mode = ObsMode::kRgb};
  const auto batch = make(id, options);
  std::uint64_t hash = checksum(Queries(*batch).document());
  const PhysicsModel& physics = batch->physics_model();
  for (const mjModel* model : {&physics.full(), &physics.robot()}) {
    std::vector<std::byte> bytes(static_cast<std::size_t>(mj_sizeModel(model)));
    mj_saveModel(model, nullptr, bytes.data(), static_cast<int>(bytes.size()));
    hash = checksum(bytes, hash);
  }
  batch->reset();
  for (int i = 0; i < kSteps; ++i) {
    test::step(*batch, i % 2 == 0 ? Policy::kOracle : Policy::kRandom);
  }
  hash = checksum(test::batch_bytes(*batch), hash);
  return checksum(std::as_bytes(batch->images().rgb), hash);
}

// Not for itself: what the other one runs in processes of their own.
TEST_CASE("Bits of the last task of every family", "[.][print_bits]") {
  std::map<std::string_view, std::string_view> last;
  for (const RegistryEntry& entry : registry()) last[entry.family] = entry.id;
  for (const auto& [family, id] : last) std::printf("bits of %s %016lx\n", id.data(), bits_of(id));
  // True if the C library obeys the setting.
  std::uint64_t sines = kChecksumSeed;
  for (int i = 0; i < 10000; ++i) {
    const double sine = std::sin(0.37 * i);
    sines = checksum(std::as_bytes(std::span(&sine, 1)), sines);
  }
  std::printf("sines %016lx\n", sines);
}

struct Printed {
  std::vector<std::string> bits;
  std::string sines;
};

Printed print_bits(const std::string& environment) {
  Printed printed;
  for (const std::string& line : test::lines_of_own_process("print_bits", environment)) {
    if (line.starts_with("bits of")) printed.bits.push_back(line);
    if (line.starts_with("sines")) printed.sines = line;
  }
  return printed;
}

TEST_CASE("The C library's kind of processor changes no bits", "[determinism]") {
  const Printed here = print_bits("");
  const Printed there = print_bits(kOldProcessor);
  CHECK(here.bits.size() > 20);
  CHECK(here.bits == there.bits);
  if (__builtin_cpu_supports("fma") && here.sines == there.sines) {
    WARN("the C library has the same sines everywhere, or ignored the setting");
  }
}

}  // namespace
}  // namespace engram
