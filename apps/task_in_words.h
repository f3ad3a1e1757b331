// The description of a task for people.
#pragma once

#include <string>

#include "protocol/formats/document.h"

namespace engram::apps {

// What describe_task tells, in sections.
std::string describe_in_words(const Document& task);

}  // namespace engram::apps
