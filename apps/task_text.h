// The description of a task as plain text.
#pragma once

#include <string>

#include "protocol/io/json.h"

namespace engram::apps {

// The content of describe_task, in sections.
std::string task_text(const Json& task);

}  // namespace engram::apps
