// The stream of libav, which is loaded when the first film begins: its 100 libraries take longer to
// load than most commands run.
#include <dlfcn.h>

#include <string>

#include "core/base/error.h"
#include "core/base/module.h"
#include "media/video_stream.h"

namespace engram {

std::unique_ptr<VideoStream> open_video_stream(const std::string& path, const std::string& file,
                                               VideoFormat format, const VideoShape& shape) {
  using Open = VideoStream*(const std::string&, const std::string&, VideoFormat, const VideoShape&);
  const auto open =
      reinterpret_cast<Open*>(module_function("libengram_video.so", "engram_open_video_stream"));
  if (open == nullptr) {
    throw Error(Error::kUnavailable, "'" + path + "' cannot be written: " + ::dlerror());
  }
  return std::unique_ptr<VideoStream>(open(path, file, format, shape));
}

}  // namespace engram
