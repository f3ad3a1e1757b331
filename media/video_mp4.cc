// .mp4: H.264, encoded as the pictures come.
#include "media/video_encoder.h"

namespace engram {
namespace {

class Mp4Encoder final : public VideoWriter::Encoder {
 public:
  Mp4Encoder(const std::string& path, const std::string& file, const VideoShape& shape)
      : stream_(open_video_stream(path, file, VideoFormat::kMp4, shape)) {}

  void add(std::span<const std::uint8_t> rgb) override { stream_->send_rgb(rgb); }
  void finish() override { stream_->finish(); }

 private:
  std::unique_ptr<VideoStream> stream_;
};

}  // namespace

std::unique_ptr<VideoWriter::Encoder> make_mp4_encoder(const std::string& path,
                                                       const std::string& file,
                                                       const VideoShape& shape) {
  return std::make_unique<Mp4Encoder>(path, file, shape);
}

}  // namespace engram
