// Streams of PyAV, in a child process: python/engram/command/video.py, which has the same messages.
// So wheels need no codecs of their own.
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/base/python_program.h"
#include "media/video_stream.h"

namespace engram {
namespace {

constexpr const char* kPython = "ENGRAM_PYTHON";  // the environment variable
constexpr const char* kEncoder =
    "from engram.command.video import main\n"
    "sys.exit(main())\n";
constexpr char kImage = 'p';    // its bytes follow
constexpr char kPalette = 'c';  // 256 entries follow
constexpr char kEnd = 'e';
// The child process inherits the video's file as descriptor 3: names of open files are valid only
// in the process that has them.
constexpr std::string_view kOpenFiles = "/proc/self/fd/";
constexpr int kVideo = 3;

class PythonStream final : public VideoStream {
 public:
  PythonStream(const std::string& path, const std::string& file, VideoFormat format,
               const VideoShape& shape)
      : path_(path) {
    const char* python = std::getenv(kPython);
    if (python == nullptr) {
      throw Error(Error::kUnavailable, "'" + path +
                                           "' cannot be written: this command makes films " +
                                           "when it is started by Python, as `engram`");
    }
    const int video = ::open(file.c_str(), O_RDWR | O_CLOEXEC);
    if (video < 0) fail(std::strerror(errno));
    const bool open = file.starts_with(kOpenFiles);
    const std::string name = open ? std::string(kOpenFiles) + std::to_string(kVideo) : file;
    start({python, "-c", python_program(kEncoder), name,
           format == VideoFormat::kMp4 ? "mp4" : "gif", std::to_string(shape.width),
           std::to_string(shape.height), std::to_string(shape.frames_per_second)},
          video);
  }
  // Without an end message, the child process stops.
  ~PythonStream() override {
    if (to_ != nullptr) std::fclose(to_);
    if (from_ >= 0) ::close(from_);
    if (process_ >= 0) ::waitpid(process_, nullptr, 0);
  }
  PythonStream(const PythonStream&) = delete;
  PythonStream& operator=(const PythonStream&) = delete;

  void send_rgb(std::span<const std::uint8_t> rgb) override { write(kImage, std::as_bytes(rgb)); }
  void send_indexed(std::span<const std::uint8_t> indices,
                    std::span<const std::uint32_t, 256> palette) override {
    write(kPalette, std::as_bytes(palette));
    write(kImage, std::as_bytes(indices));
  }
  void finish() override {
    write(kEnd, {});
    if (std::fclose(std::exchange(to_, nullptr)) != 0) fail();
    const std::string text = read_error();
    if (!text.empty()) fail(text);
  }

 private:
  // Closes `video` here.
  void start(std::array<std::string, 8> words, int video) {
    std::array<int, 2> input{-1, -1};
    std::array<int, 2> output{-1, -1};
    const auto no_pipe = [&] {
      const int error = errno;
      ::close(video);
      if (input[0] >= 0) ::close(input[0]);
      fail(std::strerror(error));
    };
    if (::pipe2(input.data(), O_CLOEXEC) != 0) no_pipe();
    to_ = ::fdopen(input[1], "w");
    if (::pipe2(output.data(), O_CLOEXEC) != 0) no_pipe();
    from_ = output[0];
    std::array<char*, words.size() + 1> arguments{};
    for (std::size_t i = 0; i < words.size(); ++i) arguments[i] = words[i].data();
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, input[0], STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&files, output[1], STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&files, video, kVideo);
    const int error =
        ::posix_spawnp(&process_, arguments[0], &files, nullptr, arguments.data(), ::environ);
    posix_spawn_file_actions_destroy(&files);
    ::close(input[0]);
    ::close(output[1]);
    ::close(video);
    if (error != 0) {
      process_ = -1;
      fail(words[0] + " cannot be started: " + std::strerror(error));
    }
  }

  void write(char kind, std::span<const std::byte> bytes) {
    const bool good =
        std::fputc(kind, to_) != EOF &&
        (bytes.empty() || std::fwrite(bytes.data(), 1, bytes.size(), to_) == bytes.size());
    if (!good) fail();
  }

  // The error text of the child process; empty if the file is complete.
  std::string read_error() {
    std::string text;
    std::array<char, 512> part{};
    for (ssize_t got = 0; (got = ::read(from_, part.data(), part.size())) != 0;) {
      if (got > 0) text.append(part.data(), static_cast<std::size_t>(got));
      if (got < 0 && errno != EINTR) break;
    }
    int status = 0;
    ::waitpid(std::exchange(process_, -1), &status, 0);
    return text.empty() && status != 0 ? "the process that encodes it failed" : text;
  }

  [[noreturn]] void fail(const std::string& reason) const {
    throw Error(Error::kIo, "'" + path_ + "' cannot be written: " + reason);
  }
  // Fails with the reason why the child process has stopped reading.
  [[noreturn]] void fail() {
    const std::string text = read_error();
    fail(text.empty() ? "the process that encodes it has ended" : text);
  }

  std::string path_;
  pid_t process_ = -1;
  std::FILE* to_ = nullptr;  // its standard input
  int from_ = -1;            // its standard output
};

}  // namespace

std::unique_ptr<VideoStream> open_video_stream(const std::string& path, const std::string& file,
                                               VideoFormat format, const VideoShape& shape) {
  return std::make_unique<PythonStream>(path, file, format, shape);
}

}  // namespace engram
