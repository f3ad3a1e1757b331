// Contexts without a display: threads, teardown, and machines that have none.
#include "render/egl/context.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "render/egl/egl_renderer.h"
#include "tests/render/has_egl.h"

namespace engram {
namespace {

// Clears a small framebuffer to a colour and reads it back.
int draw_level(const EglContext& context, int level) {
  const EglContext::Current current(context);
  if (!current.ok()) return -1;
  const Gl& gl = context.gl();
  GLuint framebuffer = 0;
  GLuint buffer = 0;
  gl.GenFramebuffers(1, &framebuffer);
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  gl.GenRenderbuffers(1, &buffer);
  gl.BindRenderbuffer(GL_RENDERBUFFER, buffer);
  gl.RenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, 16, 16);
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, buffer);
  const float color[4] = {static_cast<float>(level) / 255, 0, 0, 1};
  gl.ClearBufferfv(GL_COLOR, 0, color);
  std::uint8_t pixel[4] = {};
  gl.ReadPixels(3, 5, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, pixel);
  gl.DeleteFramebuffers(1, &framebuffer);
  gl.DeleteRenderbuffers(1, &buffer);
  return pixel[0];
}

std::size_t open_files() {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    count += entry.path().empty() ? 0 : 1;
  }
  return count;
}

std::size_t resident_bytes() {
  std::FILE* file = std::fopen("/proc/self/statm", "r");
  unsigned long total = 0;
  unsigned long resident = 0;
  const int read = std::fscanf(file, "%lu %lu", &total, &resident);
  std::fclose(file);
  return read == 2 ? resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) : 0;
}

RenderScene one_ball() {
  RenderScene scene;
  scene.geoms.resize(1);
  scene.geoms[0].shape = RenderShape::kSphere;
  scene.geoms[0].size[0] = 1;
  scene.cameras.push_back({"camera", 1.0F});
  return scene;
}

}  // namespace

TEST_CASE("EGL names what it draws with", "[render][egl]") {
  const EglInfo info = query_egl();
  if (!info.available) {
    CHECK_FALSE(info.problem.empty());
    return;
  }
  WARN("EGL " << info.platform << ": " << info.vendor << ", " << info.renderer << ", OpenGL "
              << info.version << (info.software ? " (software)" : ""));
  CHECK(info.problem.empty());
  CHECK_FALSE(info.vendor.empty());
  CHECK_FALSE(info.renderer.empty());
  CHECK_FALSE(info.platform.empty());
}

TEST_CASE("Each thread can have contexts of its own", "[render][egl]") {
  if (!has_egl()) return;
  constexpr int kThreads = 4;
  std::vector<int> wrong(kThreads, 0);
  std::vector<std::thread> threads;
  for (int i = 0; i < kThreads; ++i) {
    threads.emplace_back([&wrong, i] {
      for (int round = 0; round < 5; ++round) {
        const EglContext context(round % 2 == 0 ? GlProfile::kCore : GlProfile::kCompatibility);
        const int level = 10 * i + round;
        if (draw_level(context, level) != level) ++wrong[static_cast<std::size_t>(i)];
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(wrong == std::vector<int>(kThreads, 0));
}

TEST_CASE("A context moves between threads and nests", "[render][egl]") {
  if (!has_egl()) return;
  const EglContext first(GlProfile::kCore);
  const EglContext second(GlProfile::kCore);
  CHECK(draw_level(first, 40) == 40);
  int elsewhere = 0;
  std::thread([&] { elsewhere = draw_level(first, 41); }).join();
  CHECK(elsewhere == 41);

  const EglContext::Current outer(first);
  GLuint framebuffer = 0;
  first.gl().GenFramebuffers(1, &framebuffer);
  first.gl().BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  CHECK(draw_level(second, 42) == 42);
  GLint bound = 0;
  first.gl().GetIntegerv(GL_FRAMEBUFFER_BINDING, &bound);
  CHECK(bound == static_cast<GLint>(framebuffer));
}

TEST_CASE("Contexts and renderers leave nothing behind", "[render][egl]") {
  if (!has_egl()) return;
  const RenderScene scene = one_ball();
  const float pose[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -3};
  const float camera[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
  const float rgba[4] = {1, 1, 1, 1};
  const float emission = 0;
  const std::uint8_t visible = 1;
  std::vector<std::uint8_t> rgb(64 * 64 * 3);
  const auto round = [&] {
    const auto renderer = make_egl_renderer(scene, {}, 2);
    for (int worker = 0; worker < 2; ++worker) {
      const RenderImage image = {0, 64, 64, rgb.data(), 3, 192, nullptr, nullptr};
      renderer->render(worker, {pose, rgba, &emission, &visible, camera}, {&image, 1});
    }
    return rgb[3 * (64 * 32 + 32)];
  };
  for (int i = 0; i < 5; ++i) CHECK(round() > 0);
  const std::size_t files = open_files();
  const std::size_t memory = resident_bytes();
  for (int i = 0; i < 20; ++i) round();
  CHECK(open_files() == files);
  const double grown = static_cast<double>(resident_bytes()) - static_cast<double>(memory);
  CAPTURE(grown);
  CHECK(grown < 20e6);
}

// Run by the test below, in a process whose EGL finds no driver.
TEST_CASE("EGL without drivers", "[.][egl-without-drivers]") {
  CHECK_FALSE(query_egl().available);
  for (int attempt = 0; attempt < 2; ++attempt) {
    try {
      make_egl_renderer(one_ball(), {}, 1);
      FAIL("made a renderer");
    } catch (const Error& error) {
      CHECK(error.kind() == Error::kUnavailable);
      CHECK_THAT(error.what(), Catch::Contains("EGL") && Catch::Contains("libegl-mesa0"));
    }
  }
}

TEST_CASE("Without a driver the error says what is missing", "[render][egl]") {
  const pid_t child = fork();
  if (child == 0) {
    setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/nowhere.json", 1);
    const int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, STDOUT_FILENO);
    execl("/proc/self/exe", "engram_tests", "[egl-without-drivers]", nullptr);
    _exit(99);
  }
  REQUIRE(child > 0);
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
}

}  // namespace engram
