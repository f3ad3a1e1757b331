// `engram record`: its files, its JSON and its refusals.
#include <catch2/catch.hpp>
#include <fstream>
#include <string>

#include "tests/apps/command.h"
#include "tests/build_paths.h"
#include "tests/media/video_reader.h"
#include "tests/sanitizers.h"

namespace engram::test {
namespace {

using test::read_video, test::ReadFrame, test::ReadVideo;

constexpr const char* kId = "RememberColor3-VLA-v0";

std::string arguments(const std::filesystem::path& out, const std::string& options) {
  return std::string("record ") + kId + " --no-shadows --out '" + out.string() + "' " + options;
}

// Records and decodes.
ReadVideo record(const std::filesystem::path& out, const std::string& options) {
  const ParsedJson report = engram_command(arguments(out, options + " --json")).json();
  CHECK(keys_of(report) == std::vector<std::string>{"out", "frames", "success_once", "obs_mode",
                                                    "action_chunk_size", "model"});
  CHECK(report["out"] == out.string());
  return read_video(out.string());
}

std::size_t files_in(const std::filesystem::path& folder) {
  const std::filesystem::directory_iterator files(folder);
  return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

// A policy of zero actions, in chunks of three.
std::string idle_policy(const TemporaryFolder& folder) {
  const auto file = folder.path() / "idle.py";
  const auto examples = std::filesystem::path(test::kRoot) / "python" / "examples";
  std::ofstream(file)
      << "import sys\n"
         "sys.path.insert(0, '" +
             examples.string() +
             "')\n"
             "import pipe_policy\n"
             "greet = pipe_policy.greet\n"
             "def note_size(message):\n"
             "    global size\n"
             "    hello = greet(message)\n"
             "    size = hello['action']\n"
             "    return hello\n"
             "pipe_policy.greet = note_size\n"
             "pipe_policy.act = lambda task, request: [((3, size), [0.0] * 3 * size)]\n"
             "pipe_policy.main()\n";
  return " --policy-command 'python3 -B " + file.string() + "' ";
}

bool saturated(const Color& color) {
  const int low = std::min({color.red, color.green, color.blue});
  const int high = std::max({color.red, color.green, color.blue});
  return high > 150 && low < 40;
}

}  // namespace

TEST_CASE("record: videos have a frame of the beginning and one after every step", "[apps]") {
  const TemporaryFolder folder;
  for (const char* name : {"a.mp4", "a.gif"}) {
    const auto out = folder.path() / name;
    const ParsedJson report = engram_command(arguments(out, "--size 64 --hold 0,0 --json")).json();
    CHECK(report["frames"] == 26);
    CHECK(report["success_once"] == true);
    CHECK(report["obs_mode"] == "none");
    CHECK(report["action_chunk_size"] == 1);
    CHECK(report["model"]["name"] == "oracle");
    const ReadVideo video = read_video(out.string());
    REQUIRE(video.frames.size() == 26);
    CHECK(video.frames[0].width == 96);
    CHECK(video.frames[0].height == 64);
    CHECK(video.rate == Approx(20).epsilon(0.1));
  }
  CHECK(record(folder.path() / "b.mp4", "--camera base --size 64 --steps 4 --fps 10 --hold 0,0")
            .rate == 10);
  CHECK(read_video((folder.path() / "b.mp4").string()).frames.size() == 5);
  CHECK(files_in(folder.path()) == 3);
}

TEST_CASE("record: films last as long as their episode, ends held", "[apps]") {
  const TemporaryFolder folder;
  for (const char* name : {"a.mp4", "a.gif"}) {
    const auto out = folder.path() / name;
    CHECK(engram_command(arguments(out, "--size 64")).out.find("84 frames (4.20 s)") !=
          std::string::npos);
    const ReadVideo film = read_video(out.string());
    // 25 control steps of 50 ms; the beginning stays for 1 s, the end for 2 s.
    REQUIRE(film.frames.size() == 84);
    CHECK(film.seconds == Approx(1 + 24 * 0.05 + 2).margin(0.02));
    CHECK(engram_command(arguments(out, "--size 64 --fps 10 --hold 0,1 --json")).json()["frames"] ==
          1 + 24 + 10);
  }
}

TEST_CASE("record: multiples of the steps' rate repeat frames, other rates do not", "[apps]") {
  const TemporaryFolder folder;
  const auto films = [&](const char* name, const std::string& options) {
    return record(folder.path() / name, "--size 64 --steps 4 " + options);
  };
  const ReadVideo smooth = films("a.mp4", "--fps 60 --hold 0,0");
  REQUIRE(smooth.frames.size() == 5 * 3);
  CHECK(smooth.rate == 60);
  CHECK(smooth.seconds == Approx(5 * 0.05).margin(0.001));
  CHECK(films("b.mp4", "--fps 60").frames.size() == 60 + 3 * 3 + 120);
  CHECK(films("c.gif", "--fps 40 --hold 0,0").seconds == Approx(5 * 0.05).margin(0.02));
  // A frame for each step: half as fast, and 1.5 times.
  CHECK(films("d.mp4", "--fps 10 --hold 0,0").seconds == Approx(0.5).margin(0.001));
  CHECK(films("e.mp4", "--fps 30 --hold 0,0").frames.size() == 5);

  // Every image stays for two frames.
  const ReadVideo plain = films("f.gif", "--hold 0,0");
  const ReadVideo twice = films("g.gif", "--fps 40 --hold 0,0");
  REQUIRE(twice.frames.size() == 2 * plain.frames.size());
  for (std::size_t i = 0; i < twice.frames.size(); ++i) {
    CHECK(twice.frames[i].rgb == plain.frames[i / 2].rgb);
  }
}

TEST_CASE("record: every camera, at every size", "[apps]") {
  const TemporaryFolder folder;
  for (const char* camera : {"base", "hand", "render"}) {
    const auto out = folder.path() / (std::string(camera) + ".png");
    const ReadVideo image = record(out, std::string("--width 33 --height 21 --camera ") + camera);
    REQUIRE(image.frames.size() == 1);
    CHECK(image.frames[0].width == 33);
    CHECK(image.frames[0].height == 21);
  }
  CHECK(read_file(folder.path() / "base.png") != read_file(folder.path() / "hand.png"));
  CHECK(read_file(folder.path() / "base.png") != read_file(folder.path() / "render.png"));
  const ReadVideo standard = record(folder.path() / "all.png", "");
  CHECK(standard.frames[0].width == 768);
  CHECK(standard.frames[0].height == 512);
}

TEST_CASE("record: the composition shows the cameras where they belong", "[apps]") {
  const TemporaryFolder folder;
  const ReadFrame all = record(folder.path() / "all.png", "--size 128").frames.at(0);
  const struct {
    const char* camera;
    int size, left, top;
  } parts[] = {{"render", 128, 0, 0}, {"base", 64, 128, 0}, {"hand", 64, 128, 64}};
  for (const auto& part : parts) {
    const auto out = folder.path() / "part.png";
    const ReadFrame single =
        record(out, std::string("--camera ") + part.camera + " --size " + std::to_string(part.size))
            .frames.at(0);
    int same = 0;
    for (int y = 0; y < part.size; ++y) {
      for (int x = 0; x < part.size; ++x) {
        if (single.at(x, y) == all.at(part.left + x, part.top + y)) ++same;
      }
    }
    INFO(part.camera);
    const int pixels = part.size * part.size;
    // Labels cover some of the sensors.
    CHECK(same <= (part.left == 0 ? pixels : pixels - 20));
    CHECK(same >= (part.left == 0 ? pixels : pixels * 9 / 10));
  }
  const ReadFrame coarse =
      record(folder.path() / "coarse.png", "--size 128 --sensor-size 16").frames.at(0);
  CHECK(coarse.rgb != all.rgb);
  CHECK(coarse.at(20, 100) == all.at(20, 100));
}

TEST_CASE("record: overlays show step, reward and target", "[apps]") {
  const TemporaryFolder folder;
  const std::string options = "--camera render --overlays --pin target=1";
  const ReadFrame first = record(folder.path() / "a.png", options).frames.at(0);
  CHECK(first.at(141, 49) == Color{0, 255, 0});
  CHECK(first.at(130, 49) == kWhite);
  const ReadFrame bare =
      record(folder.path() / "b.png", "--camera render --pin target=1").frames.at(0);
  CHECK_FALSE(saturated(bare.at(141, 49)));
  int below = 0;  // nothing is drawn there
  for (int x = 0; x < 512; ++x) below += first.at(x, 200) == bare.at(x, 200) ? 1 : 0;
  CHECK(below == 512);
}

TEST_CASE("record: images of moments, and sheets of them", "[apps]") {
  const TemporaryFolder folder;
  const std::string base = "--camera base --size 40 ";
  const ReadFrame sheet = record(folder.path() / "at.png", base + "--at 0,9,2,25").frames.at(0);
  // Three columns and two rows of 40 x 40, labels of 8 and gutters of 2 pixels.
  CHECK(sheet.width == 124);
  CHECK(sheet.height == 98);
  const ReadFrame second = record(folder.path() / "two.png", base + "--at 2").frames.at(0);
  CHECK(second.at(20, 30) == sheet.at(42 + 20, 8 + 30));
  CHECK(second.at(5, 5) == sheet.at(42 + 5, 8 + 5));
  CHECK(sheet.at(40, 20) == kBlack);   // a gutter
  CHECK(sheet.at(100, 70) == kBlack);  // no image there
  bool labelled = false;
  for (int x = 0; x < 40; ++x) labelled |= sheet.at(x, 4) != kBlack;
  CHECK(labelled);

  const auto out = folder.path() / "sheet.png";
  const ParsedJson report = engram_command(arguments(out, base + "--sheet 6 --json")).json();
  CHECK(report["frames"] == 6);
  CHECK(report["success_once"] == true);
  CHECK(read_video(out.string()).frames.at(0).width == 124);
}

TEST_CASE("record: images and sheets have shadows, unless they are turned off", "[apps]") {
  const TemporaryFolder folder;
  const auto bytes = [&](const char* name, const std::string& options) {
    const auto out = folder.path() / name;
    REQUIRE(engram_command(std::string("record ") + kId + " --camera render --size 64 --out '" +
                           out.string() + "' " + options)
                .code == 0);
    return read_file(out);
  };
  CHECK(bytes("a.png", "") == bytes("b.png", "--shadows"));
  CHECK(bytes("a.png", "") != bytes("c.png", "--no-shadows"));
  CHECK(bytes("a.mp4", "--steps 2") == bytes("b.mp4", "--steps 2 --no-shadows"));
}

TEST_CASE("record: the same arguments give the same bytes, another seed others", "[apps]") {
  const TemporaryFolder folder;
  const std::string options = "--camera base --size 64 --steps 6 --seed ";
  record(folder.path() / "a.mp4", options + "4");
  record(folder.path() / "b.mp4", options + "4");
  record(folder.path() / "c.mp4", options + "5");
  CHECK(read_file(folder.path() / "a.mp4") == read_file(folder.path() / "b.mp4"));
  CHECK(read_file(folder.path() / "a.mp4") != read_file(folder.path() / "c.mp4"));
}

TEST_CASE("record: an external policy observes the same as in an evaluation", "[apps]") {
  const TemporaryFolder folder;
  // The observations of the policy are recorded, too.
  const auto command = [&](const char* copy) {
    return " --policy-command 'tee " + (folder.path() / copy).string() + " | " + pipe_policy() +
           "' ";
  };
  for (const std::string obs : {"", "--obs state", "--obs objects"}) {
    INFO(obs);
    const ParsedJson task = engram_command(std::string("eval ") + kId + " --episodes 1 --json " +
                                           obs + command("evaluated"))
                                .json()["tasks"][0];
    const ParsedJson report =
        engram_command(arguments(folder.path() / "a.mp4",
                                 "--size 64 --seed 4242424242 --hold 0,0 --json --policy-name "
                                 "mine " +
                                     obs + command("recorded")))
            .json();
    CHECK(report["frames"] == 26);
    CHECK(report["success_once"] == task["successes"][0]);
    CHECK(report["obs_mode"] == task["obs_mode"]);
    CHECK(report["action_chunk_size"] == 4);
    CHECK(report["model"]["name"] == "mine");
    CHECK_THAT(report["model"]["config"]["command"], Catch::Contains(pipe_policy()));
    const std::string seen = read_file(folder.path() / "recorded");
    CHECK(seen.size() > 1000);
    CHECK(seen == read_file(folder.path() / "evaluated"));
    // Sheets show the same episode, for which the policy is asked once.
    engram_command(arguments(folder.path() / "sheet.png",
                             "--sheet 4 --size 64 --seed 4242424242 " + obs + command("sheet")));
    CHECK(read_file(folder.path() / "sheet") == seen);
  }
}

TEST_CASE("record: an external policy acts for every view and file", "[apps]") {
  const TemporaryFolder folder;
  const std::string idle = idle_policy(folder);
  const auto expect_same = [&](const char* name, const std::string& options) {
    const auto own = folder.path() / (std::string("own_") + name);
    const auto outside = folder.path() / (std::string("command_policy_") + name);
    record(own, options + " --policy zero");
    record(outside, options + idle);
    INFO(name << " " << options);
    CHECK(read_file(own) == read_file(outside));
  };
  expect_same("a.mp4", "--size 64");
  expect_same("a.gif", "--size 64 --camera hand");
  expect_same("a.png", "--camera render --overlays --at 3");
  expect_same("b.png", "--camera base --size 40 --at 0,4,25");
  expect_same("c.png", "--size 64 --sensor-size 16 --sheet 5");
  expect_same("d.png", "--size 64 --steps 7 --sheet 3 --pin target=1");
  expect_same("e.mp4", "--size 64 --steps 5 --control-mode pd_joint_pos");
}

TEST_CASE("record: a policy process that fails is reported and leaves no file", "[apps]") {
  const TemporaryFolder folder;
  const auto refuse = [&](const std::string& command, int code, const std::string& words,
                          const std::string& options = "") {
    const std::string given = "--size 64 " + options + " --policy-command '" + command + "'";
    require_refusal(arguments(folder.path() / "a.mp4", given), code, words);
    require_refusal(arguments(folder.path() / "a.png", "--sheet 3 " + given), code, words);
    CHECK(files_in(folder.path()) == 0);
  };
  refuse("exit 3", 1, "ended with exit code 3");
  refuse("echo hello, world; cat >/dev/null", 1, "standard output");
  refuse("cat >/dev/null", 1, "within 1 s", "--policy-timeout 1");
  refuse(pipe_policy(), 1, "(4, 7) given, (8), (K, 8)", "--control-mode pd_joint_pos");
  refuse(pipe_policy(), 2, "--policy", "--policy oracle");
  refuse(pipe_policy(), 2, "state|rgb|objects", "--obs depth");
  // A policy that hangs does not delay Ctrl-C.
  // engram is the parent of its parent, the guard.
  refuse("kill -INT $(cut -d\" \" -f4 /proc/$PPID/stat); cat >/dev/null", 1,
         "interrupted; nothing was written");
}

TEST_CASE("record: refusals are one line and leave nothing behind", "[apps]") {
  const TemporaryFolder folder;
  const auto refuse = [&](const char* name, const std::string& options, int code,
                          const std::string& words) {
    require_refusal(arguments(folder.path() / name, options), code, words);
    CHECK(files_in(folder.path()) == 0);
  };
  require_refusal(std::string("record ") + kId, 2, "--out");
  refuse("a.avi", "", 2, ".png, .gif or .mp4");
  refuse("a.png", "--camera top", 2, "base|hand|render|all");
  refuse("a.png", "--size 0", 2, "1 to 4096");
  refuse("a.png", "--camera base --width 4097", 2, "1 to 4096");
  refuse("a.mp4", "--size 510", 2, "multiples of 4");
  refuse("a.mp4", "--camera base --size 127", 2, "even");
  refuse("a.gif", "--fps 60", 2, "1 to 50");
  refuse("a.png", "--fps 60", 2, "videos only");
  refuse("a.png", "--hold 0,0", 2, "videos only");
  refuse("a.mp4", "--hold 3", 2, "FIRST,LAST");
  refuse("a.mp4", "--hold 0,61", 2, "0 to 60");
  refuse("a.png", "--width 64", 2, "--size");
  refuse("a.png", "--camera base --size 64 --width 64", 2, "--size");
  refuse("a.png", "--camera base --overlays", 2, "render|all");
  refuse("a.png", "--camera base --sensor-size 64", 2, "--camera all");
  refuse("a.png", "--at 26", 2, "26 given, 0 to 25 allowed; the episode ends with step 25");
  refuse("a.png", "--at 3,26", 2, "0 to 25 allowed");
  refuse("a.png", "--at 2,", 2, "whole number");
  refuse("a.png", "--sheet 61", 2, "1 to 60");
  refuse("a.mp4", "--sheet 2", 2, ".png allowed");
  refuse("a.mp4", "--renderer vulkan", 2, "cpu or egl");
  refuse("a.mp4", "--auto-reset off", 2, "--auto-reset");
  refuse("a.mp4", "--obs state", 2, "--policy-command");
  refuse("a.mp4", "--pin target=3", 2, "target");
  refuse("a.mp4", "--control-mode pd_ee_pose", 2, "pd_ee_delta_pose");
  for (const char* name : {"nowhere/a.png", "nowhere/a.gif", "nowhere/a.mp4"}) {
    refuse(name, "--size 64", 1, name);
  }
}

TEST_CASE("record: a full disk leaves the old file as it was", "[apps]") {
  const TemporaryFolder folder;
  for (const char* name : {"a.png", "a.gif", "a.mp4"}) {
    const auto out = folder.path() / name;
    std::ofstream(out) << "old";
    // No file may grow beyond 8 blocks of 512 bytes.
    const std::string line = std::string("(trap '' XFSZ; ulimit -f 8; ") +
                             test::kNoTemporaryFolder + "'" + test::kCommand + "' " +
                             arguments(out, "--size 128") + " 2>&1) | grep -q '" + name + "'";
    CHECK(std::system(line.c_str()) == 0);
    CHECK(read_file(out) == "old");
  }
  CHECK(files_in(folder.path()) == 3);
}

}  // namespace engram::test
