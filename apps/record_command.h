// `engram record`: an episode as an image or a video.
#pragma once

#include "apps/command_line.h"

namespace engram::apps {

void add_record_command(const Command& program);

}  // namespace engram::apps
