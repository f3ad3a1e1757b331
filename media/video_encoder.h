// Encoders of the formats of VideoWriter.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "media/video_stream.h"

namespace engram {

class VideoEncoder {
 public:
  virtual ~VideoEncoder() = default;
  virtual void add(std::span<const std::uint8_t> rgb) = 0;
  virtual void finish() = 0;
};

// Writes to `file`; messages name `path`.
std::unique_ptr<VideoEncoder> make_video_encoder(const std::string& path, const std::string& file,
                                                 VideoFormat format, const VideoShape& shape);

}  // namespace engram
