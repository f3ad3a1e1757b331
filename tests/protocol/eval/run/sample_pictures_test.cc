#include "protocol/eval/run/sample_pictures.h"

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

TEST_CASE("A strip of samples has as many pictures as the episode allows", "[evaluation]") {
  MakeOptions options;
  options.num_envs = 1;
  options.threads = 1;
  options.auto_reset = AutoReset::kOff;
  const auto env = make("RememberColor3-VLA-v0", options);
  env->reset();
  SamplePictures pictures;
  pictures.sample(*env, 0);
  CHECK(size_of(pictures.png()) == std::pair{SamplePictures::kSide, SamplePictures::kSide});
  std::vector<float> actions(static_cast<std::size_t>(env->action_dim()));
  while ((env->terminated()[0] | env->truncated()[0]) == 0) {
    env->step(actions);
    pictures.sample(*env, 0);
  }
  CHECK(size_of(pictures.png()) ==
        std::pair{SamplePictures::kPictures * SamplePictures::kSide, SamplePictures::kSide});
}

}  // namespace
}  // namespace engram
