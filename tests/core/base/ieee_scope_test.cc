// Whatever mode the host program computes in, the bits are the same, and it gets its mode back.
#include "core/base/ieee_scope.h"

#include "core/batch/queries.h"
#include "core/batch/scene_renderer.h"
#include "core/batch/scripted_policy.h"
#include "core/batch/snapshot.h"

#if defined(__SSE__)  // modes are set by hand here

#include <atomic>
#include <catch2/catch.hpp>

#include "core/threads/thread_pool.h"
#include "protocol/make/make.h"
#include "tests/env_helpers.h"
#include "tests/host_mode.h"

namespace engram {
namespace {

using test::Host;
using test::HostMode;

struct Played {
  test::Bytes bytes;  // everything shown and remembered, images too
  std::string text;
  int changed = 0;
};

template <class T>
void append(test::Bytes& to, std::span<const T> values) {
  const auto bytes = std::as_bytes(values);
  to.insert(to.end(), bytes.begin(), bytes.end());
}

// An episode's beginning, a snapshot and its restoration, made in one mode and played in another.
Played play(const std::string& id, const HostMode& when_made, const HostMode& later) {
  Played played;
  const BatchOptions options{.num_envs = 3,
                             .threads = 2,
                             .chunk = 1,
                             .obs_mode = ObsMode::kRgb,
                             .auto_reset = AutoReset::kSameStep};
  std::unique_ptr<Batch> batch;
  Host maker(when_made);
  maker.run([&] { batch = make(id, options); });

  Host host(later);
  const auto note = [&] {
    append<std::byte>(played.bytes, test::batch_bytes(*batch));
    append(played.bytes, batch->images().rgb);
  };
  std::vector<float> actions = test::zeros(*batch);
  const auto play_on = [&](Policy policy) {
    host.run([&] { ScriptedPolicy(*batch, policy).act(actions); });
    host.run([&] { batch->step(actions); });
    note();
  };
  host.run([&] { batch->reset(); });
  note();
  for (int i = 0; i < 4; ++i) play_on(i % 2 == 0 ? Policy::kRandom : Policy::kOracle);
  test::Bytes saved;
  host.run([&] { saved = Snapshotter(*batch).save(); });
  for (int i = 0; i < 3; ++i) play_on(Policy::kRandom);
  host.run([&] { Snapshotter(*batch).restore(saved); });
  note();
  play_on(Policy::kOracle);
  std::vector<std::uint8_t> image(std::size_t{3} * 48 * 48);
  host.run([&] { SceneRenderer(*batch).render(0, "render_camera", 48, 48, image); });
  append<std::uint8_t>(played.bytes, image);
  host.run([&] { played.text = Queries(*batch).document() + Queries(*batch).instruction(0); });
  played.changed = maker.changed() + host.changed();
  return played;
}

TEST_CASE("An IEEE scope sets the default mode and gives back what was set", "[base]") {
  for (const HostMode& mode : test::host_modes()) {
    const HostMode with_flag{mode.sse | 0x0020, mode.x87};  // something has been inexact
    HostMode inside;
    HostMode between;
    Host host(with_flag);
    host.run([&] {
      const IeeeScope scope;
      inside = HostMode::current().control();
      { const IeeeScope inner; }
      between = HostMode::current().control();
    });
    CHECK(inside == HostMode());
    CHECK(between == HostMode());
    CHECK(host.changed() == 0);
  }
}

TEST_CASE("An IEEE scope undoes what is set within it", "[base]") {
  for (const HostMode& mode : test::host_modes()) {
    Host host{HostMode()};
    host.run([&] {
      const IeeeScope scope;
      mode.set();
    });
    CHECK(host.changed() == 0);
  }
}

TEST_CASE("A mode that traps can be restored after an operation that it would trap", "[base]") {
  Host host(test::host_modes().back());
  double quotient = 0;
  host.run([&] {
    const IeeeScope scope;
    volatile long double zero = 0;
    quotient = static_cast<double>(1 / zero);
  });
  CHECK(quotient > 1e300);
  CHECK(host.changed() == 0);
}

TEST_CASE("Loops compute in the default mode on all threads", "[base]") {
  std::unique_ptr<ThreadPool> pool;
  Host host(test::host_modes().back());
  host.run([&] { pool = std::make_unique<ThreadPool>(4); });
  std::atomic<int> others = 0;
  std::atomic<int> done = 0;
  for (int i = 0; i < 20; ++i) {
    host.run([&] {
      pool->run(64, 1, [&](int, int, int) {
        ++done;
        if (HostMode::current().control() != HostMode()) ++others;
      });
    });
  }
  CHECK(done == 20 * 64);
  CHECK(others == 0);
  CHECK(host.changed() == 0);
}

void check_modes(const std::string& id, std::span<const HostMode> modes) {
  CAPTURE(id);
  const Played usual = play(id, {}, {});
  for (const HostMode& mode : modes) {
    CAPTURE(mode.sse, mode.x87);
    for (const HostMode& when_made : {HostMode(), mode}) {
      const Played played = play(id, when_made, mode);
      CHECK(played.bytes == usual.bytes);
      CHECK(played.text == usual.text);
      CHECK(played.changed == 0);
    }
  }
}

TEST_CASE("The host's mode of arithmetic changes no bits and stays as it is", "[determinism]") {
  check_modes("RotateLenientPos-VLA-v0", test::host_modes());
  const std::vector<HostMode> modes = test::host_modes();
  const HostMode some[] = {modes[12], modes[25], modes[39]};
  for (const char* id :
       {"ShellGamePick-VLA-v0", "RememberShape3-VLA-v0", "InterceptGrabFast-VLA-v0",
        "TraceShapeMedium-VLA-v0", "BatteriesCheckerEasy-3-VLA-v0", "TimedTransferEasy-VLA-v0"}) {
    check_modes(id, some);
  }
}

}  // namespace
}  // namespace engram

#endif
