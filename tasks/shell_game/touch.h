// ShellGameTouch: a ball vanishes under one of three mugs; that mug has to be touched.
#pragma once

#include "tasks/family.h"

namespace engram::tasks {

// ShellGameTouch-VLA-v0 and ShellGameTouch-v0.
extern const Family kShellGameTouch;

}  // namespace engram::tasks
