// Reads what the video writer and the PNG writer have written, with libav.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "media/canvas.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libswscale/swscale.h>
}

namespace engram::test {

struct ReadFrame {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;

  Color at(int x, int y) const {
    const std::uint8_t* pixel =
        rgb.data() + 3 * (static_cast<std::ptrdiff_t>(y) * width + static_cast<std::ptrdiff_t>(x));
    return {pixel[0], pixel[1], pixel[2]};
  }
};

struct ReadVideo {
  std::string codec;
  double seconds = 0;  // from the first frame to the end of the last
  double rate = 0;     // frames per second, as far as the container says
  std::vector<ReadFrame> frames;
};

inline ReadFrame to_rgb(const AVFrame& frame) {
  ReadFrame out{frame.width, frame.height, {}};
  out.rgb.resize(3 * static_cast<std::size_t>(frame.width) *
                 static_cast<std::size_t>(frame.height));
  SwsContext* converter = sws_getContext(
      frame.width, frame.height, static_cast<AVPixelFormat>(frame.format), frame.width,
      frame.height, AV_PIX_FMT_RGB24, SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT, nullptr,
      nullptr, nullptr);
  const int* matrix = sws_getCoefficients(SWS_CS_ITU709);
  sws_setColorspaceDetails(converter, matrix, 0, matrix, 1, 0, 1 << 16, 1 << 16);
  std::uint8_t* const to[] = {out.rgb.data()};
  const int stride[] = {3 * frame.width};
  sws_scale(converter, frame.data, frame.linesize, 0, frame.height, to, stride);
  sws_freeContext(converter);
  return out;
}

// Takes all frames that are ready.
inline void receive(AVCodecContext* decoder, AVFrame* frame, ReadVideo& video) {
  while (avcodec_receive_frame(decoder, frame) >= 0) video.frames.push_back(to_rgb(*frame));
}

// A video without frames if the file cannot be read.
inline ReadVideo read_video(const std::string& path) {
  ReadVideo video;
  av_log_set_level(AV_LOG_QUIET);
  AVFormatContext* container = nullptr;
  if (avformat_open_input(&container, path.c_str(), nullptr, nullptr) < 0) return video;
  avformat_find_stream_info(container, nullptr);
  const AVStream* stream = container->streams[0];
  const AVCodec* codec = avcodec_find_decoder(stream->codecpar->codec_id);
  AVCodecContext* decoder = avcodec_alloc_context3(codec);
  avcodec_parameters_to_context(decoder, stream->codecpar);
  avcodec_open2(decoder, codec, nullptr);
  video.codec = codec->name;
  video.seconds = static_cast<double>(container->duration) / AV_TIME_BASE;
  video.rate = av_q2d(stream->r_frame_rate);
  AVPacket* packet = av_packet_alloc();
  AVFrame* frame = av_frame_alloc();
  while (av_read_frame(container, packet) >= 0) {
    avcodec_send_packet(decoder, packet);
    av_packet_unref(packet);
    receive(decoder, frame, video);
  }
  avcodec_send_packet(decoder, nullptr);
  receive(decoder, frame, video);
  av_frame_free(&frame);
  av_packet_free(&packet);
  avcodec_free_context(&decoder);
  avformat_close_input(&container);
  return video;
}

// Largest difference of a channel.
inline int distance(const Color& a, const Color& b) {
  const int red = std::abs(a.red - b.red);
  const int green = std::abs(a.green - b.green);
  const int blue = std::abs(a.blue - b.blue);
  return std::max({red, green, blue});
}

}  // namespace engram::test
