// Makes batches of environments from ids, with everything that draws their pictures.
#pragma once

#include <memory>
#include <string_view>

#include "core/base/error.h"
#include "core/env/batch.h"
#include "tasks/registry.h"

namespace engram {

// A batch of environments of the task with that id. Throws Error: kUnknownId (with the nearest
// id), kUnavailable if its family is not part of this version, kInvalidArgument for a bad option.
std::unique_ptr<Batch> make(std::string_view id, const MakeOptions& options);
std::unique_ptr<Batch> make(std::string_view id, const BatchOptions& options = {});
// The same, with another factory of renderers.
std::unique_ptr<Batch> make(std::string_view id, const MakeOptions& options,
                            RendererFactory renderers);

// Version of the library, "0.5.0".
const char* version();

}  // namespace engram
