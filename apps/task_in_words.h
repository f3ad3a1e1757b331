// The description of a task for people.
#pragma once

#include <string>

#include "apps/json.h"

namespace engram::apps {

// What describe_task tells, in sections.
std::string describe_in_words(const Json& task);

}  // namespace engram::apps
