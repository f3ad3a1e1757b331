#include "media/video.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "core/base/error.h"
#include "tests/apps/command.h"
#include "tests/media/video_reader.h"

namespace engram {
namespace {

using test::distance, test::read_file, test::read_video, test::ReadVideo, test::TemporaryFolder;
using Bytes = std::vector<std::uint8_t>;

constexpr int kWidth = 96;
constexpr int kHeight = 64;
constexpr Color kBack = {150, 100, 60};
constexpr Color kSquare = {20, 60, 220};

// A square that goes to the right, 2 pixels per frame.
Bytes moving_square(int frame) {
  Canvas canvas(kWidth, kHeight, kBack);
  canvas.fill({4.0 + 2 * frame, 20, 24, 24}, kSquare);
  return canvas.rgb();
}

void write(const std::string& path, int frames, int rate) {
  VideoWriter video(path, kWidth, kHeight, rate);
  for (int i = 0; i < frames; ++i) video.add(moving_square(i));
  video.finish();
}

}  // namespace

TEST_CASE("video: every frame is there, in its colours, at its time", "[render]") {
  const TemporaryFolder folder;
  for (const char* name : {"a.mp4", "b.GIF", "with: colon.mp4"}) {
    const std::string path = (folder.path() / name).string();
    INFO(path);
    write(path, 21, 30);
    const ReadVideo video = read_video(path);
    REQUIRE(video.frames.size() == 21);
    CHECK(video.seconds == Approx(0.7).margin(0.011));
    CHECK(video.rate == Approx(30).epsilon(0.1));
    for (const int i : {0, 7, 20}) {
      const auto& frame = video.frames[static_cast<std::size_t>(i)];
      CHECK(frame.width == kWidth);
      CHECK(frame.height == kHeight);
      CHECK(distance(frame.at(16 + 2 * i, 32), kSquare) <= 6);
      CHECK(distance(frame.at(90, 8), kBack) <= 6);
    }
    CHECK(distance(video.frames[20].at(16, 32), kBack) <= 6);
  }
  CHECK(read_video((folder.path() / "a.mp4").string()).codec == "h264");
  // The index is in front, so that players need not wait for the end.
  const std::string bytes = read_file(folder.path() / "a.mp4");
  CHECK(bytes.find("moov") < bytes.find("mdat"));
}

TEST_CASE("video: the same frames are the same bytes", "[render]") {
  const TemporaryFolder folder;
  for (const char* extension : {".mp4", ".gif"}) {
    const auto one = folder.path() / (std::string("one") + extension);
    const auto two = folder.path() / (std::string("two") + extension);
    write(one.string(), 12, 20);
    write(two.string(), 12, 20);
    CHECK(read_file(one) == read_file(two));
  }
}

TEST_CASE("video: one frame is a video", "[render]") {
  const TemporaryFolder folder;
  for (const char* name : {"a.mp4", "a.gif"}) {
    const std::string path = (folder.path() / name).string();
    write(path, 1, 30);
    CHECK(read_video(path).frames.size() == 1);
  }
}

TEST_CASE("video: what is not finished leaves nothing behind", "[render]") {
  const TemporaryFolder folder;
  for (const char* name : {"a.mp4", "a.gif"}) {
    const std::string path = (folder.path() / name).string();
    {
      VideoWriter video(path, kWidth, kHeight, 30);
      video.add(moving_square(0));
      CHECK_THROWS_AS(video.add(Bytes(17)), Error);
      CHECK_FALSE(std::filesystem::exists(path));
    }
    CHECK(std::filesystem::is_empty(folder.path()));
    {
      VideoWriter video(path, kWidth, kHeight, 30);
      CHECK_THROWS_WITH(video.finish(), Catch::Contains("without a frame"));
    }
    CHECK(std::filesystem::is_empty(folder.path()));
  }
}

TEST_CASE("video: links are replaced, and what a killed process left goes", "[render]") {
  const TemporaryFolder folder;
  const std::filesystem::path other = folder.path() / "other";
  std::ofstream(other) << "precious";
  for (const char* name : {"a.mp4", "a.gif"}) {
    const std::string path = (folder.path() / name).string();
    std::filesystem::create_symlink(other, path);
    std::ofstream(path + ".0123456789abcdef.engram-tmp") << "half";
    write(path, 2, 30);
    CHECK(read_video(path).frames.size() == 2);
    std::filesystem::remove(path);
  }
  CHECK(test::read_file(other) == "precious");
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()),
                      std::filesystem::directory_iterator()) == 1);
}

TEST_CASE("video: refusals say what is allowed", "[render]") {
  const TemporaryFolder folder;
  const auto open = [&](const char* name, int width, int height, int rate) {
    VideoWriter video((folder.path() / name).string(), width, height, rate);
  };
  CHECK_THROWS_WITH(open("a.avi", 64, 64, 30), Catch::Contains(".mp4 or .gif"));
  CHECK_THROWS_WITH(open("mp4", 64, 64, 30), Catch::Contains(".mp4 or .gif"));
  CHECK_THROWS_WITH(open("a.mp4", 63, 64, 30),
                    Catch::Contains("63 x 64") && Catch::Contains("even"));
  CHECK_THROWS_WITH(open("a.gif", 0, 64, 30), Catch::Contains("2 to 8192"));
  CHECK_THROWS_WITH(open("a.mp4", 64, 10000, 30), Catch::Contains("64 x 10000"));
  CHECK_THROWS_WITH(open("a.mp4", 64, 64, 0), Catch::Contains("1 to 240"));
  CHECK_THROWS_WITH(open("a.gif", 64, 64, 60), Catch::Contains("1 to 50"));
  for (const char* name : {"nowhere/a.mp4", "nowhere/a.gif"}) {
    try {
      open(name, 64, 64, 30);
      FAIL("no error");
    } catch (const Error& error) {
      CHECK(error.kind() == Error::kIo);
      CHECK_THAT(error.what(), Catch::Contains(name) && Catch::Contains("No such file"));
    }
  }
  std::filesystem::create_directory(folder.path() / "folder.gif");
  CHECK_THROWS_WITH(open("folder.gif", 64, 64, 30), Catch::Contains("directory"));
  std::filesystem::remove(folder.path() / "folder.gif");
  CHECK(std::filesystem::is_empty(folder.path()));
}

}  // namespace engram
