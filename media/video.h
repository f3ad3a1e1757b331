// Videos as files.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace engram {

class VideoEncoder;

// Writes .mp4 (H.264) or .gif, by the end of the path. The file appears whole, by finish(), or not
// at all. The same frames give the same bytes with the same versions of the libraries.
class VideoWriter {
 public:
  static constexpr int kMaxSide = 8192;  // pixels

  // Throws Error if the path ends in anything else, the size or rate is out of range (sides of
  // 2 to kMaxSide pixels, even ones for .mp4; 1 to 240 frames a second, 50 for .gif), or the file
  // cannot be written.
  VideoWriter(const std::string& path, int width, int height, int frames_per_second);
  ~VideoWriter();  // leaves nothing behind that is not finished
  VideoWriter(VideoWriter&&) noexcept;
  VideoWriter& operator=(VideoWriter&&) noexcept;

  // (height, width, 3), row 0 on top. Throws Error if that is not the length, or on failure.
  void add(std::span<const std::uint8_t> rgb);
  // Throws Error if no frame was added, or on failure. To be called once.
  void finish();

 private:
  struct File;
  std::unique_ptr<File> file_;
  std::unique_ptr<VideoEncoder> encoder_;
};

}  // namespace engram
