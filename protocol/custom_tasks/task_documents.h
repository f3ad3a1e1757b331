// Tasks with rules outside of the library, as JSON: their definition and their description
// (docs/custom_tasks.md).
#pragma once

#include <string_view>

#include "protocol/io/json.h"
#include "tasks/custom/custom_family.h"

namespace engram {

// Throw Error (kInvalidArgument) if the text is not JSON, a key is missing, unknown or of the wrong
// type, or a value is out of range.
tasks::CustomDefinition parse_definition(std::string_view json);
// what: the task, for messages.
tasks::CustomDescription parse_task_description(std::string_view json, std::string_view what);

}  // namespace engram
