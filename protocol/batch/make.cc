#include "protocol/batch/make.h"

#include "render/document_source.h"

namespace engram {

std::unique_ptr<Batch> make(std::string_view id, const EnvOptions& options) {
  check_ranges(options);
  return std::make_unique<Batch>(make_task(id, options.constants, options.max_episode_steps),
                                 options, make_document_source);
}

const char* version() { return ENGRAM_VERSION; }

}  // namespace engram
