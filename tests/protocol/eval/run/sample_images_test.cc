#include "protocol/eval/run/sample_images.h"

#include <catch2/catch.hpp>
#include <cstring>
#include <string>

namespace engram {
namespace {

// Width and height in the header of a PNG.
std::pair<int, int> size_of(const Bytes& png) {
  const auto number = [&png](std::size_t at) {
    int value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | std::to_integer<int>(png.at(at + i));
    return value;
  };
  return {number(16), number(20)};
}

TEST_CASE("A strip of samples has as many images as the episode allows", "[evaluation]") {
  MakeOptions options;
  options.num_envs = 1;
  options.threads = 1;
  options.auto_reset = AutoReset::kOff;
  const auto batch = make("RememberColor3-VLA-v0", options);
  batch->reset();
  SampleImages images;
  images.sample(*batch, 0);
  CHECK(size_of(images.png()) == std::pair{SampleImages::kSide, SampleImages::kSide});
  std::vector<float> actions(static_cast<std::size_t>(batch->action_dim()));
  while ((batch->outputs().terminated[0] | batch->outputs().truncated[0]) == 0) {
    batch->step(actions);
    images.sample(*batch, 0);
  }
  CHECK(size_of(images.png()) ==
        std::pair{SampleImages::kImages * SampleImages::kSide, SampleImages::kSide});
}

}  // namespace
}  // namespace engram
