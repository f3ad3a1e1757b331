#include "media/video.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "core/base/error.h"
#include "core/base/temporary_file.h"
#include "media/video_encoder.h"

namespace engram {
namespace {

constexpr int kMaxRate = 240;
constexpr int kMaxGifRate = 50;  // viewers slow down faster ones

VideoFormat format_of(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".mp4") return VideoFormat::kMp4;
  if (extension == ".gif") return VideoFormat::kGif;
  throw Error(Error::kInvalidArgument,
              "video: '" + path + "' given, a name that ends in .mp4 or .gif allowed");
}

void check(const VideoShape& shape, VideoFormat format) {
  const bool mp4 = format == VideoFormat::kMp4;
  const int parity = mp4 ? 2 : 1;  // colours come in blocks of 2 x 2 pixels
  for (const int side : {shape.width, shape.height}) {
    if (side >= 2 && side <= VideoWriter::kMaxSide && side % parity == 0) continue;
    throw Error(Error::kInvalidArgument, "video of " + std::to_string(shape.width) + " x " +
                                             std::to_string(shape.height) + " pixels given, " +
                                             (mp4 ? "even " : "") + "sides of 2 to " +
                                             std::to_string(VideoWriter::kMaxSide) + " allowed");
  }
  const int max_rate = mp4 ? kMaxRate : kMaxGifRate;
  if (shape.frames_per_second < 1 || shape.frames_per_second > max_rate) {
    throw Error(Error::kInvalidArgument, "video with " + std::to_string(shape.frames_per_second) +
                                             " frames per second given, 1 to " +
                                             std::to_string(max_rate) + " allowed");
  }
}

}  // namespace

struct VideoWriter::File {
  explicit File(const std::string& path) : temporary(path) {}

  TemporaryFile temporary;
  std::size_t frame_bytes = 0;
  std::size_t frames = 0;
};

VideoWriter::VideoWriter(const std::string& path, int width, int height, int frames_per_second) {
  const VideoFormat format = format_of(path);
  const VideoShape shape{width, height, frames_per_second};
  check(shape, format);
  if (std::filesystem::is_directory(path)) {
    throw Error(Error::kIo, "'" + path + "' cannot be written: " + std::strerror(EISDIR));
  }
  remove_temporary_files_of(path);
  file_ = std::make_unique<File>(path);
  file_->frame_bytes = shape.frame_bytes();
  const std::string file = file_->temporary.open_name();
  encoder_ = make_video_encoder(path, file, format, shape);
}

VideoWriter::~VideoWriter() = default;
VideoWriter::VideoWriter(VideoWriter&&) noexcept = default;
VideoWriter& VideoWriter::operator=(VideoWriter&&) noexcept = default;

void VideoWriter::add(std::span<const std::uint8_t> rgb) {
  require_length("frame", rgb.size(), file_->frame_bytes);
  encoder_->add(rgb);
  ++file_->frames;
}

void VideoWriter::finish() {
  if (file_->frames == 0) throw Error(Error::kBadState, "video without a frame");
  encoder_->finish();
  file_->temporary.keep();
}

}  // namespace engram
