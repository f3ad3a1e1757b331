// RememberColor, RememberShape and RememberShapeAndColor: one object shows its colour, its shape or
// both, it vanishes, then K objects appear and the one that was shown has to be touched
// (docs/tasks/remember.md).
#pragma once

#include "tasks/family.h"

namespace engram::tasks {

// RememberColor{3,5,9}, RememberShape{3,5,9}, RememberShapeAndColor{3x2,3x3,5x3}; -VLA-v0,
// -Long-VLA-v0 and -v0.
extern const Family kRememberColor;
extern const Family kRememberShape;
extern const Family kRememberShapeAndColor;

}  // namespace engram::tasks
