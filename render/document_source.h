// Pictures of MJCF documents: how the engine reaches the renderers.
#pragma once

#include "core/image/image_source.h"
#include "render/cpu_renderer.h"

namespace engram {

// Makes image sources with the renderer that the options name: "cpu" or "egl". With shadows, the
// slanted light casts soft ones. Throws Error for another name, a refused document, or a renderer
// that cannot work here.
std::unique_ptr<ImageSource> make_document_source(const std::string& document,
                                                  const std::vector<std::string>& bodies,
                                                  const ImageSourceOptions& options, int workers);

// The same with the ray caster on that instruction set. All of them draw the same: for checks.
std::unique_ptr<ImageSource> make_document_source_on(InstructionSet set,
                                                     const std::string& document,
                                                     const std::vector<std::string>& bodies,
                                                     const ImageSourceOptions& options,
                                                     int workers);

}  // namespace engram
