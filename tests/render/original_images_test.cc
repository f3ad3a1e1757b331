// Images held against figures of the original's: tests/data/original_pictures.json has, of each
// image, the draws of its episode, the mean colours of its blocks of 8 x 8 pixels, and the
// colours of faces at pixels that show them. The original's lamps have other bulbs: blocks with
// them are left out. original_link_pixels.json has how many pixels of the base camera show each
// link, in poses given as noise on the start pose's joints.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "core/batch/scene_renderer.h"
#include "protocol/make/make.h"
#include "tests/build_paths.h"

namespace {

using namespace engram;
using ParsedJson = nlohmann::json;

constexpr int kSize = 128;
constexpr int kBlock = 8;
constexpr int kBlocks = kSize / kBlock;  // in a row or column
constexpr int kFewLevels = 4;
constexpr int kSomeLevels = 8;

using Image = std::vector<std::uint8_t>;
using Color = std::array<double, 3>;

// The arm held still, the gripper open.
Image draw(const ParsedJson& original) {
  BatchOptions options{.threads = 1, .freeze_cue = false};
  for (const auto& [name, values] : original["pins"].items()) {
    options.pins.push_back({name, values.get<std::vector<double>>()});
  }
  const auto batch = make(original["id"].get<std::string>(), options);
  batch->reset();
  std::vector<float> action(static_cast<std::size_t>(batch->action_dim()), 0.0F);
  action.back() = 1;
  for (int i = 0; i < original["step"].get<int>(); ++i) batch->step(action);
  Image rgb(3 * kSize * kSize);
  SceneRenderer(*batch).render(0, original["camera"].get<std::string>(), kSize, kSize, rgb);
  return rgb;
}

Color mean_of_block(const Image& rgb, int block) {
  Color sum = {};
  for (int y = 0; y < kBlock; ++y) {
    for (int x = 0; x < kBlock; ++x) {
      const int row = block / kBlocks * kBlock + y;
      const int column = block % kBlocks * kBlock + x;
      for (int k = 0; k < 3; ++k) {
        sum[static_cast<std::size_t>(k)] +=
            rgb[static_cast<std::size_t>(3 * (row * kSize + column) + k)];
      }
    }
  }
  for (double& value : sum) value /= kBlock * kBlock;
  return sum;
}

Color measured_block(const std::string& digits, int block) {
  Color color = {};
  for (std::size_t k = 0; k < 3; ++k) {
    color[k] =
        std::stoi(digits.substr(6 * static_cast<std::size_t>(block) + 2 * k, 2), nullptr, 16);
  }
  return color;
}

struct Tally {
  int blocks = 0;        // of table, floor and robot
  int alike = 0;         // whose brightness is
  int alike_levels = 0;  // three a block: whose red, green or blue is
};

void compare_blocks(const ParsedJson& original, const Image& rgb, Tally& tally) {
  std::set<int> left_out = original["bulbs"].get<std::set<int>>();
  left_out.merge(original["props"].get<std::set<int>>());
  const auto digits = original["blocks"].get<std::string>();
  for (int block = 0; block < kBlocks * kBlocks; ++block) {
    if (left_out.contains(block)) continue;
    const Color ours = mean_of_block(rgb, block);
    const Color theirs = measured_block(digits, block);
    double difference = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      difference += (ours[k] - theirs[k]) / 3;
      tally.alike_levels += std::abs(ours[k] - theirs[k]) <= kSomeLevels ? 1 : 0;
    }
    tally.alike += std::abs(difference) <= kSomeLevels ? 1 : 0;
    ++tally.blocks;
  }
}

// Returns how many faces were looked at.
int check_faces(const ParsedJson& original, const Image& rgb) {
  for (const ParsedJson& face : original["faces"]) {
    const auto x = face[0].get<int>();
    const auto y = face[1].get<int>();
    CAPTURE(original["file"], x, y);
    for (int k = 0; k < 3; ++k) {
      const int ours = rgb[static_cast<std::size_t>(3 * (y * kSize + x) + k)];
      CHECK(std::abs(ours - face[static_cast<std::size_t>(2 + k)].get<int>()) <= kFewLevels);
    }
  }
  return static_cast<int>(original["faces"].size());
}

ParsedJson parse(const char* file) {
  std::ifstream stream(std::string(test::kData) + file);
  return ParsedJson::parse(stream);
}

// Pixels of the base camera that show each body.
std::map<std::string, int> body_pixels(const std::vector<double>& robot_noise) {
  const auto batch = make("RememberColor9-VLA-v0", {.threads = 1,
                                                    .obs_mode = ObsMode::kRgbSegmentation,
                                                    .pins = {{"robot_noise", robot_noise}}});
  batch->reset();
  const auto images = batch->images();
  std::map<std::string, int> pixels;
  for (std::size_t i = 0; i < images.segmentation.size(); i += 2) {  // base camera, hand camera
    ++pixels[images.segmentation_names[static_cast<std::size_t>(images.segmentation[i])]];
  }
  return pixels;
}

}  // namespace

TEST_CASE("Links cover as many pixels as the original's", "[render][panda][original]") {
  double shown = 0;
  double different = 0;
  for (const ParsedJson& original : parse("/original_link_pixels.json")) {
    auto ours = body_pixels(original["robot_noise"].get<std::vector<double>>());
    for (const auto& [link, pixels] : original["pixels"].items()) {
      shown += pixels.get<int>();
      different += std::abs(ours[link] - pixels.get<int>());
    }
  }
  CHECK(shown > 10'000);
  CHECK(different <= 0.07 * shown);
}

TEST_CASE("Images are coloured and lit as the original's are", "[render]") {
  const ParsedJson originals = parse("/original_pictures.json");
  REQUIRE(originals.size() == 40);
  std::map<std::string, Tally> tallies;
  int faces = 0;
  for (const ParsedJson& original : originals) {
    const Image rgb = draw(original);
    compare_blocks(original, rgb, tallies[original["camera"].get<std::string>()]);
    faces += check_faces(original, rgb);
  }
  CHECK(faces > 100);
  REQUIRE(tallies.size() == 2);
  for (const auto& [camera, tally] : tallies) {
    CAPTURE(camera, tally.blocks, tally.alike, tally.alike_levels);
    CHECK(tally.blocks > 4000);
    const bool base = camera == "base_camera";
    CHECK(tally.alike >= (base ? 0.94 : 0.90) * tally.blocks);
    CHECK(tally.alike_levels >= (base ? 0.92 : 0.88) * 3 * tally.blocks);
  }
}
