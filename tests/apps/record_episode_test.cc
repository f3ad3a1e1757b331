#include "apps/record_episode.h"

#include <catch2/catch.hpp>

namespace engram::apps {
namespace {

TEST_CASE("A rewound episode takes the same steps", "[apps]") {
  EpisodeOptions options;
  options.id = "RememberColor3-VLA-v0";
  options.env.num_envs = 1;
  options.env.threads = 1;
  options.env.auto_reset = AutoReset::kOff;
  options.policy = Policy::kRandom;
  options.steps = 6;
  const Interruption interruption(0);
  RecordedEpisode episode(options, interruption);
  CHECK(episode.max_steps() == 6);
  CHECK(episode.chunk_size() == 1);
  while (!episode.over()) episode.step();
  CHECK(episode.steps() == 6);
  const auto seen = episode.batch().outputs().observation;
  const std::vector<float> last(seen.begin(), seen.end());
  episode.rewind();
  CHECK(episode.steps() == 0);
  while (!episode.over()) episode.step();
  const auto again = episode.batch().outputs().observation;
  CHECK(std::vector<float>(again.begin(), again.end()) == last);
}

TEST_CASE("A command observes images of the default size", "[apps]") {
  EpisodeOptions options;
  options.env.obs_mode = ObsMode::kNone;
  options.env.image_options.antialias = true;
  const MakeOptions observed = options.observed();
  CHECK(observed.obs_mode == ObsMode::kRgb);
  CHECK_FALSE(observed.image_options.antialias);
}

}  // namespace
}  // namespace engram::apps
