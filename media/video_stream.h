// Codecs: one encoded stream in one file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace engram {

struct VideoShape {
  int width = 0;
  int height = 0;
  int frames_per_second = 0;

  std::size_t frame_bytes() const {
    return 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
};

enum class VideoFormat { kMp4, kGif };

// All members throw Error on failure.
class VideoStream {
 public:
  virtual ~VideoStream() = default;
  // The next image of an .mp4: rows of red, green and blue.
  virtual void send_rgb(std::span<const std::uint8_t> rgb) = 0;
  // The next image of a .gif: rows of entries of a palette, each 0xAARRGGBB.
  virtual void send_indexed(std::span<const std::uint8_t> indices,
                            std::span<const std::uint32_t, 256> palette) = 0;
  virtual void finish() = 0;
};

// A stream of libav (libav/) or PyAV (video_python.cc), chosen by the build. It writes to `file`;
// messages name `path`.
std::unique_ptr<VideoStream> open_video_stream(const std::string& path, const std::string& file,
                                               VideoFormat format, const VideoShape& shape);

}  // namespace engram
