// `engram record`: an episode as a picture or a video.
#pragma once

#include <CLI/CLI.hpp>

namespace engram::apps {

void add_record_command(CLI::App& app);

}  // namespace engram::apps
