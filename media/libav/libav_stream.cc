// Streams by libav: H.264 in the colours of high-definition video with the index in front, and GIF.
// Loaded by open_video_stream().
#include <algorithm>
#include <array>
#include <string>

#include "core/base/error.h"
#include "media/video_stream.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

namespace engram {
namespace {

constexpr const char* kQuality = "18";  // of x264: differences that are hard to see
constexpr std::int64_t kBitRate = 8'000'000;
// Fixed, not one per core of the machine: what x264 writes depends on the number.
constexpr int kThreads = 4;

const AVCodec* find_encoder(VideoFormat format) {
  if (format == VideoFormat::kGif) return avcodec_find_encoder(AV_CODEC_ID_GIF);
  const AVCodec* x264 = avcodec_find_encoder_by_name("libx264");
  return x264 != nullptr ? x264 : avcodec_find_encoder(AV_CODEC_ID_H264);
}

void describe_mp4(AVCodecContext& codec) {
  codec.pix_fmt = AV_PIX_FMT_YUV420P;
  codec.color_range = AVCOL_RANGE_MPEG;
  codec.colorspace = AVCOL_SPC_BT709;
  codec.color_primaries = AVCOL_PRI_BT709;
  codec.color_trc = AVCOL_TRC_BT709;
  codec.thread_count = kThreads;
  codec.bit_rate = kBitRate;  // for encoders that know no constant quality
  if (codec.priv_data == nullptr) return;
  av_opt_set(codec.priv_data, "preset", "medium", 0);
  if (av_opt_set(codec.priv_data, "crf", kQuality, 0) >= 0) codec.bit_rate = 0;
}

struct FreeScaler {
  void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
};
using Converter = std::unique_ptr<SwsContext, FreeScaler>;

Converter rgb_to_yuv(const VideoShape& shape) {
  Converter converter(sws_getContext(
      shape.width, shape.height, AV_PIX_FMT_RGB24, shape.width, shape.height, AV_PIX_FMT_YUV420P,
      SWS_BICUBIC | SWS_ACCURATE_RND | SWS_BITEXACT | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP,
      nullptr, nullptr, nullptr));
  if (!converter) throw Error(Error::kUnavailable, "libswscale cannot convert to yuv420p");
  const int* bt709 = sws_getCoefficients(SWS_CS_ITU709);
  constexpr int kUnit = 1 << 16;
  sws_setColorspaceDetails(converter.get(), bt709, 1, bt709, 0, 0, kUnit, kUnit);
  return converter;
}

struct Handles {
  Handles() = default;
  ~Handles() {
    av_packet_free(&packet);
    av_frame_free(&frame);
    avcodec_free_context(&codec);
    if (container != nullptr) avio_closep(&container->pb);
    avformat_free_context(container);
  }
  Handles(const Handles&) = delete;
  Handles& operator=(const Handles&) = delete;

  AVFormatContext* container = nullptr;
  AVCodecContext* codec = nullptr;
  AVFrame* frame = av_frame_alloc();
  AVPacket* packet = av_packet_alloc();
};

class LibavStream final : public VideoStream {
 public:
  LibavStream(const std::string& path, const std::string& file, VideoFormat format,
              const VideoShape& shape);

  void send_rgb(std::span<const std::uint8_t> rgb) override;
  void send_indexed(std::span<const std::uint8_t> indices,
                    std::span<const std::uint32_t, 256> palette) override;
  void finish() override;

 private:
  void open_codec(VideoFormat format);
  void open_file(const std::string& file, VideoFormat format);
  // The next frame, to be filled in and then sent.
  AVFrame& frame();
  void send();
  void write_packets();
  void require(int result, const char* what) const;

  std::string path_;
  VideoShape shape_;
  Handles av_;
  Converter converter_;  // of .mp4
  std::int64_t frames_ = 0;
};

LibavStream::LibavStream(const std::string& path, const std::string& file, VideoFormat format,
                         const VideoShape& shape)
    : path_(path), shape_(shape) {
  av_log_set_level(AV_LOG_QUIET);  // a library does not print
  const char* muxer = format == VideoFormat::kMp4 ? "mp4" : "gif";
  require(avformat_alloc_output_context2(&av_.container, nullptr, muxer, nullptr), muxer);
  open_codec(format);
  open_file(file, format);
  av_.frame->format = av_.codec->pix_fmt;
  av_.frame->width = shape.width;
  av_.frame->height = shape.height;
  require(av_frame_get_buffer(av_.frame, 0), "frame");
  if (format == VideoFormat::kMp4) converter_ = rgb_to_yuv(shape);
}

void LibavStream::require(int result, const char* what) const {
  if (result >= 0) return;
  std::array<char, AV_ERROR_MAX_STRING_SIZE> reason = {};
  av_strerror(result, reason.data(), reason.size());
  throw Error(Error::kIo,
              "'" + path_ + "' cannot be written: " + reason.data() + " (" + what + ")");
}

void LibavStream::open_codec(VideoFormat format) {
  const AVCodec* encoder = find_encoder(format);
  if (encoder == nullptr) {
    throw Error(Error::kUnavailable,
                "'" + path_ + "' cannot be written: libavcodec has no encoder for " +
                    (format == VideoFormat::kMp4 ? "H.264; install one with libx264" : "GIF"));
  }
  av_.codec = avcodec_alloc_context3(encoder);
  AVCodecContext& codec = *av_.codec;
  codec.width = shape_.width;
  codec.height = shape_.height;
  codec.time_base = {1, shape_.frames_per_second};
  codec.framerate = {shape_.frames_per_second, 1};
  codec.pix_fmt = AV_PIX_FMT_PAL8;
  codec.flags |= AV_CODEC_FLAG_BITEXACT;
  if (format == VideoFormat::kMp4) describe_mp4(codec);
  if ((av_.container->oformat->flags & AVFMT_GLOBALHEADER) != 0) {
    codec.flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  }
  require(avcodec_open2(&codec, encoder, nullptr), encoder->name);
}

void LibavStream::open_file(const std::string& file, VideoFormat format) {
  AVFormatContext& container = *av_.container;
  AVStream* stream = avformat_new_stream(&container, nullptr);
  if (stream == nullptr) throw Error(Error::kUnavailable, "out of memory");
  stream->time_base = av_.codec->time_base;
  stream->avg_frame_rate = av_.codec->framerate;
  require(avcodec_parameters_from_context(stream->codecpar, av_.codec), "stream");
  container.flags |= AVFMT_FLAG_BITEXACT;  // neither time nor version in the file
  // A URL, because other names with a colon would be taken for protocols.
  const std::string url = "file:" + file;
  container.url = av_strdup(url.c_str());  // read again by faststart
  require(avio_open(&container.pb, url.c_str(), AVIO_FLAG_WRITE), "open");
  AVDictionary* options = nullptr;
  if (format == VideoFormat::kMp4) av_dict_set(&options, "movflags", "+faststart", 0);
  const int result = avformat_write_header(&container, &options);
  av_dict_free(&options);
  require(result, "header");
}

AVFrame& LibavStream::frame() {
  require(av_frame_make_writable(av_.frame), "frame");
  return *av_.frame;
}

void LibavStream::send_rgb(std::span<const std::uint8_t> rgb) {
  AVFrame& to = frame();
  const std::uint8_t* const from[] = {rgb.data()};
  const int stride[] = {3 * shape_.width};
  sws_scale(converter_.get(), from, stride, 0, shape_.height, to.data, to.linesize);
  send();
}

void LibavStream::send_indexed(std::span<const std::uint8_t> indices,
                               std::span<const std::uint32_t, 256> palette) {
  AVFrame& to = frame();
  std::copy(palette.begin(), palette.end(), reinterpret_cast<std::uint32_t*>(to.data[1]));
  const auto width = static_cast<std::size_t>(shape_.width);
  for (int y = 0; y < shape_.height; ++y) {
    std::copy_n(&indices[static_cast<std::size_t>(y) * width], width,
                to.data[0] + static_cast<std::ptrdiff_t>(y) * to.linesize[0]);
  }
  send();
}

void LibavStream::send() {
  av_.frame->pts = frames_++;
  require(avcodec_send_frame(av_.codec, av_.frame), "frame");
  write_packets();
}

void LibavStream::write_packets() {
  AVPacket& packet = *av_.packet;
  while (true) {
    const int result = avcodec_receive_packet(av_.codec, &packet);
    if (result == AVERROR(EAGAIN) || result == AVERROR_EOF) return;
    require(result, "encode");
    packet.duration = 1;
    packet.stream_index = 0;
    av_packet_rescale_ts(&packet, av_.codec->time_base, av_.container->streams[0]->time_base);
    require(av_interleaved_write_frame(av_.container, &packet), "write");
    require(av_.container->pb->error, "write");
  }
}

void LibavStream::finish() {
  require(avcodec_send_frame(av_.codec, nullptr), "frame");
  write_packets();
  require(av_write_trailer(av_.container), "trailer");
  require(av_.container->pb->error, "write");
  require(avio_closep(&av_.container->pb), "close");
}

}  // namespace
}  // namespace engram

extern "C" __attribute__((visibility("default"))) engram::VideoStream* engram_open_video_stream(
    const std::string& path, const std::string& file, engram::VideoFormat format,
    const engram::VideoShape& shape) {
  return new engram::LibavStream(path, file, format, shape);
}
