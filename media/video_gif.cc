// .gif: one palette for all frames, so they are kept in a file until the last one has come.
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "core/base/error.h"
#include "media/video_encoder.h"
#include "media/video_palette.h"

extern "C" {
#include <libavutil/frame.h>
}

namespace engram {
namespace {

// One entry is kept free: it marks pixels that have not changed since the frame before.
constexpr int kColors = 255;
constexpr int kTransparent = 255;

// Frames on disk, in a file without a name, which the system removes even after a crash.
class FrameSpool {
 public:
  FrameSpool(const std::string& path, const std::string& place) : path_(path) {
    const std::string name = place + ".frames";
    file_ = std::fopen(name.c_str(), "w+be");
    if (file_ == nullptr) fail();
    ::unlink(name.c_str());
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

class GifEncoder final : public VideoWriter::Encoder {
 public:
  GifEncoder(const std::string& path, const std::string& file, const VideoShape& shape)
      : shape_(shape), spool_(path, file), stream_(path, file, VideoFormat::kGif, shape) {}

  void add(std::span<const std::uint8_t> rgb) override {
    histogram_.add(rgb);
    spool_.write(rgb);
    ++frames_;
  }

  void finish() override {
    PaletteMap map(choose_palette(histogram_, kColors));
    std::vector<std::uint8_t> rgb(shape_.frame_bytes());
    spool_.rewind();
    for (std::size_t i = 0; i < frames_; ++i) {
      spool_.read(rgb);
      fill(stream_.frame(), rgb, map);
      stream_.send();
    }
    stream_.finish();
  }

 private:
  void fill(AVFrame& frame, std::span<const std::uint8_t> rgb, PaletteMap& map) const {
    auto* palette = reinterpret_cast<std::uint32_t*>(frame.data[1]);
    std::fill_n(palette, 256, 0xFF000000U);
    palette[kTransparent] = 0;
    for (std::size_t i = 0; i < map.palette().size(); ++i) {
      const PaletteColor& color = map.palette()[i];
      palette[i] = 0xFF000000U | static_cast<std::uint32_t>(color[0]) << 16U |
                   static_cast<std::uint32_t>(color[1]) << 8U | color[2];
    }
    const std::uint8_t* in = rgb.data();
    for (int y = 0; y < shape_.height; ++y) {
      std::uint8_t* out = frame.data[0] + static_cast<std::ptrdiff_t>(y) * frame.linesize[0];
      for (int x = 0; x < shape_.width; ++x, in += 3) out[x] = map.index_at(x, y, in);
    }
  }

  VideoShape shape_;
  FrameSpool spool_;
  VideoStream stream_;
  ColorHistogram histogram_;
  std::size_t frames_ = 0;
};

}  // namespace

std::unique_ptr<VideoWriter::Encoder> make_gif_encoder(const std::string& path,
                                                       const std::string& file,
                                                       const VideoShape& shape) {
  return std::make_unique<GifEncoder>(path, file, shape);
}

}  // namespace engram
