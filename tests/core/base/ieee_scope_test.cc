// Whatever mode the host program computes in, the bits are the same, and it gets its mode back.
#include "core/base/ieee_scope.h"

#include "core/batch/queries.h"
#include "core/batch/scene_renderer.h"
#include "core/batch/scripted_policy.h"
#include "core/batch/snapshot.h"

#if defined(__SSE__)  // modes are set by hand here

#include <atomic>
#include <catch2/catch.hpp>
#include <functional>

#include "core/threads/thread_pool.h"
#include "protocol/make/make.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

constexpr unsigned kDefault = 0x1f80;
constexpr unsigned kFlushToZero = 0x8000;
constexpr unsigned kDenormalsAreZero = 0x0040;
constexpr unsigned kUp = 0x4000;
constexpr unsigned kTowardsZero = 0x6000;
constexpr unsigned kFlushing = kDefault | kFlushToZero | kDenormalsAreZero;
constexpr unsigned kModes[] = {kFlushing | kUp, kFlushing, kDefault | kTowardsZero};

// Calls f as a host program in that mode does; counts calls that did not leave it as it was.
class Host {
 public:
  explicit Host(unsigned mode) : mode_(mode) {}
  void run(const std::function<void()>& f) {
    const unsigned before = _mm_getcsr();
    _mm_setcsr(mode_);
    f();
    const unsigned after = _mm_getcsr();
    _mm_setcsr(before);
    if (after != mode_) ++changed_;
  }
  int changed() const { return changed_; }

 private:
  unsigned mode_;
  int changed_ = 0;
};

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
Played play(const std::string& id, unsigned when_made, unsigned later) {
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
  for (const unsigned mode : kModes) {
    const unsigned with_flag = mode | 0x0020;  // something has been inexact
    unsigned inside = 0;
    unsigned between = 0;
    Host host(with_flag);
    host.run([&] {
      const IeeeScope scope;
      inside = _mm_getcsr();
      { const IeeeScope inner; }
      between = _mm_getcsr();
    });
    CHECK(inside == kDefault);
    CHECK(between == kDefault);
    CHECK(host.changed() == 0);
  }
}

TEST_CASE("Loops compute in the default mode on all threads", "[base]") {
  constexpr unsigned kControl = ~0x3fU;
  std::unique_ptr<ThreadPool> pool;
  Host host(kModes[0]);
  host.run([&] { pool = std::make_unique<ThreadPool>(4); });
  std::atomic<int> others = 0;
  std::atomic<int> done = 0;
  for (int i = 0; i < 20; ++i) {
    host.run([&] {
      pool->run(64, 1, [&](int, int, int) {
        ++done;
        if ((_mm_getcsr() & kControl) != kDefault) ++others;
      });
    });
  }
  CHECK(done == 20 * 64);
  CHECK(others == 0);
  CHECK(host.changed() == 0);
}

TEST_CASE("The host's mode of arithmetic changes no bits and stays as it is", "[determinism]") {
  for (const char* id :
       {"ShellGamePick-VLA-v0", "RememberShape3-VLA-v0", "InterceptGrabFast-VLA-v0",
        "RotateLenientPos-VLA-v0", "TraceShapeMedium-VLA-v0", "BatteriesCheckerEasy-3-VLA-v0",
        "TimedTransferEasy-VLA-v0"}) {
    CAPTURE(id);
    const Played usual = play(id, kDefault, kDefault);
    for (const unsigned mode : kModes) {
      CAPTURE(mode);
      for (const unsigned when_made : {kDefault, mode}) {
        const Played played = play(id, when_made, mode);
        CHECK(played.bytes == usual.bytes);
        CHECK(played.text == usual.text);
        CHECK(played.changed == 0);
      }
    }
  }
}

}  // namespace
}  // namespace engram

#endif
