// The description of a task as plain text.
#pragma once

#include <string>

#include "protocol/io/document.h"

namespace engram::apps {

// The content of describe_task, in sections.
std::string task_text(const Document& task);

}  // namespace engram::apps
