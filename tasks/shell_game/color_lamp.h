// ShellGameColorLampTouch: three coloured balls vanish under three mugs; a lamp then shows the
// colour whose mug has to be touched.
#pragma once

#include "tasks/family.h"

namespace engram::tasks {

// ShellGameColorLampTouch-VLA-v0.
extern const Family kShellGameColorLampTouch;

}  // namespace engram::tasks
