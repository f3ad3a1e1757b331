// Props of scenes as JSON.
#pragma once

#include <string>

#include "mjcf/prop.h"
#include "protocol/io/json.h"

namespace engram {

// Throws Error (kInvalidArgument) if a key is missing, unknown or of the wrong type, or a size is
// not positive. what: the prop's owner, for messages.
mjcf::Prop to_prop(const Json& document, const std::string& what);

}  // namespace engram
