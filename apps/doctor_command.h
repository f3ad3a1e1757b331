// `engram doctor`: what this build and this machine offer.
#pragma once

#include <CLI/CLI.hpp>

namespace engram::apps {

void add_doctor_command(CLI::App& app);

}  // namespace engram::apps
