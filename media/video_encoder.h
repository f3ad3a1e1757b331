// What the formats of VideoWriter have in common.
#pragma once

#include <memory>

#include "media/video.h"

struct AVFrame;

namespace engram {

class VideoWriter::Encoder {
 public:
  virtual ~Encoder() = default;
  virtual void add(std::span<const std::uint8_t> rgb) = 0;
  virtual void finish() = 0;
};

struct VideoShape {
  int width = 0;
  int height = 0;
  int frames_per_second = 0;

  std::size_t frame_bytes() const {
    return 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
};

// They write to `file`; messages name `path`.
std::unique_ptr<VideoWriter::Encoder> make_mp4_encoder(const std::string& path,
                                                       const std::string& file,
                                                       const VideoShape& shape);
std::unique_ptr<VideoWriter::Encoder> make_gif_encoder(const std::string& path,
                                                       const std::string& file,
                                                       const VideoShape& shape);

enum class VideoFormat { kMp4, kGif };

// One encoded stream in one file, by libav. All members throw Error on failure.
class VideoStream {
 public:
  VideoStream(const std::string& path, const std::string& file, VideoFormat format,
              const VideoShape& shape);
  ~VideoStream();
  VideoStream(const VideoStream&) = delete;
  VideoStream& operator=(const VideoStream&) = delete;

  // The next picture, to be filled in and then sent.
  AVFrame& frame();
  void send();
  void finish();

 private:
  void open_codec(VideoFormat format, const VideoShape& shape);
  void open_file(const std::string& file, VideoFormat format);
  void write_packets();
  void require(int result, const char* what) const;

  struct Handles;
  std::string path_;
  std::unique_ptr<Handles> av_;
  std::int64_t frames_ = 0;
};

}  // namespace engram
