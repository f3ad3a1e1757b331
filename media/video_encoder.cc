#include "media/video_encoder.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <vector>

#include "core/base/error.h"
#include "core/base/temporary_file.h"
#include "media/video_palette.h"

namespace engram {
namespace {

// One entry is kept free: it marks pixels that have not changed since the frame before.
constexpr int kColors = 255;
constexpr int kTransparent = 255;

// .mp4: H.264, encoded frame by frame.
class Mp4Encoder final : public VideoEncoder {
 public:
  Mp4Encoder(const std::string& path, const std::string& file, const VideoShape& shape)
      : stream_(open_video_stream(path, file, VideoFormat::kMp4, shape)) {}

  void add(std::span<const std::uint8_t> rgb) override { stream_->send_rgb(rgb); }
  void finish() override { stream_->finish(); }

 private:
  std::unique_ptr<VideoStream> stream_;
};

// Frames on disk, in a file without a name, which the system removes even after a crash.
class FrameSpool {
 public:
  explicit FrameSpool(const std::string& path) : path_(path) {
    const TemporaryFile named(path);
    file_ = std::fopen(named.open_name().c_str(), "r+be");
    if (file_ == nullptr) fail();
  }
  ~FrameSpool() { std::fclose(file_); }
  FrameSpool(const FrameSpool&) = delete;
  FrameSpool& operator=(const FrameSpool&) = delete;

  void write(std::span<const std::uint8_t> frame) {
    if (std::fwrite(frame.data(), 1, frame.size(), file_) != frame.size()) fail();
  }
  void rewind() {
    if (std::fflush(file_) != 0 || std::fseek(file_, 0, SEEK_SET) != 0) fail();
  }
  void read(std::span<std::uint8_t> frame) {
    if (std::fread(frame.data(), 1, frame.size(), file_) != frame.size()) fail();
  }

 private:
  [[noreturn]] void fail() const {
    throw Error(Error::kIo, "'" + path_ + "' cannot be written: " + std::strerror(errno));
  }

  std::string path_;
  std::FILE* file_ = nullptr;
};

// .gif: one palette for all frames, which are stored on disk until the last one is known.
class GifEncoder final : public VideoEncoder {
 public:
  GifEncoder(const std::string& path, const std::string& file, const VideoShape& shape)
      : shape_(shape),
        spool_(path),
        stream_(open_video_stream(path, file, VideoFormat::kGif, shape)) {}

  void add(std::span<const std::uint8_t> rgb) override {
    histogram_.add(rgb);
    spool_.write(rgb);
    ++frames_;
  }

  void finish() override {
    PaletteMap map(choose_palette(histogram_, kColors));
    const std::array<std::uint32_t, 256> palette = entries(map);
    std::vector<std::uint8_t> rgb(shape_.frame_bytes());
    std::vector<std::uint8_t> indices(rgb.size() / 3);
    spool_.rewind();
    for (std::size_t i = 0; i < frames_; ++i) {
      spool_.read(rgb);
      for (std::size_t k = 0; k < indices.size(); ++k) {
        const int at = static_cast<int>(k);
        indices[k] = map.index_at(at % shape_.width, at / shape_.width, &rgb[3 * k]);
      }
      stream_->send_indexed(indices, palette);
    }
    stream_->finish();
  }

 private:
  static std::array<std::uint32_t, 256> entries(const PaletteMap& map) {
    std::array<std::uint32_t, 256> palette;
    palette.fill(0xFF000000U);
    palette[kTransparent] = 0;
    for (std::size_t i = 0; i < map.palette().size(); ++i) {
      const PaletteColor& color = map.palette()[i];
      palette[i] = 0xFF000000U | static_cast<std::uint32_t>(color[0]) << 16U |
                   static_cast<std::uint32_t>(color[1]) << 8U | color[2];
    }
    return palette;
  }

  VideoShape shape_;
  FrameSpool spool_;
  std::unique_ptr<VideoStream> stream_;
  ColorHistogram histogram_;
  std::size_t frames_ = 0;
};

}  // namespace

std::unique_ptr<VideoEncoder> make_video_encoder(const std::string& path, const std::string& file,
                                                 VideoFormat format, const VideoShape& shape) {
  if (format == VideoFormat::kMp4) return std::make_unique<Mp4Encoder>(path, file, shape);
  return std::make_unique<GifEncoder>(path, file, shape);
}

}  // namespace engram
