// .mp4: H.264 in the colours of high-definition video, index in front.
#include "core/base/error.h"
#include "media/video_encoder.h"

extern "C" {
#include <libavutil/frame.h>
#include <libswscale/swscale.h>
}

namespace engram {
namespace {

struct FreeScaler {
  void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
};

class Mp4Encoder final : public VideoWriter::Encoder {
 public:
  Mp4Encoder(const std::string& path, const std::string& file, const VideoShape& shape)
      : shape_(shape),
        stream_(path, file, VideoFormat::kMp4, shape),
        converter_(sws_getContext(
            shape.width, shape.height, AV_PIX_FMT_RGB24, shape.width, shape.height,
            AV_PIX_FMT_YUV420P,
            SWS_BICUBIC | SWS_ACCURATE_RND | SWS_BITEXACT | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP,
            nullptr, nullptr, nullptr)) {
    if (!converter_) throw Error(Error::kUnavailable, "libswscale cannot convert to yuv420p");
    const int* bt709 = sws_getCoefficients(SWS_CS_ITU709);
    constexpr int kUnit = 1 << 16;
    sws_setColorspaceDetails(converter_.get(), bt709, 1, bt709, 0, 0, kUnit, kUnit);
  }

  void add(std::span<const std::uint8_t> rgb) override {
    AVFrame& frame = stream_.frame();
    const std::uint8_t* const from[] = {rgb.data()};
    const int stride[] = {3 * shape_.width};
    sws_scale(converter_.get(), from, stride, 0, shape_.height, frame.data, frame.linesize);
    stream_.send();
  }

  void finish() override { stream_.finish(); }

 private:
  VideoShape shape_;
  VideoStream stream_;
  std::unique_ptr<SwsContext, FreeScaler> converter_;
};

}  // namespace

std::unique_ptr<VideoWriter::Encoder> make_mp4_encoder(const std::string& path,
                                                       const std::string& file,
                                                       const VideoShape& shape) {
  return std::make_unique<Mp4Encoder>(path, file, shape);
}

}  // namespace engram
