#include "protocol/batch/make.h"

#include "render/make_renderer.h"

namespace engram {

std::unique_ptr<Batch> make(std::string_view id, const MakeOptions& options,
                            RendererFactory renderers) {
  check_ranges(options);
  const BatchOptions& of_batch = options;
  return std::make_unique<Batch>(make_task(id, options.constants, options.max_episode_steps),
                                 of_batch, std::move(renderers));
}

std::unique_ptr<Batch> make(std::string_view id, const MakeOptions& options) {
  return make(id, options, make_renderer);
}

std::unique_ptr<Batch> make(std::string_view id, const BatchOptions& options) {
  return make(id, MakeOptions{options, {}, 0});
}

const char* version() { return ENGRAM_VERSION; }

}  // namespace engram
