#include "protocol/batch/make.h"

#include "render/make_renderer.h"

namespace engram {

std::unique_ptr<Batch> make(std::string_view id, const EnvOptions& options) {
  check_ranges(options);
  return std::make_unique<Batch>(make_task(id, options.constants, options.max_episode_steps),
                                 options, make_renderer);
}

const char* version() { return ENGRAM_VERSION; }

}  // namespace engram
