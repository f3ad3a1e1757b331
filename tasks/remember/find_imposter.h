// FindImposterColor, FindImposterShape and FindImposterShapeAndColor: all objects but one are
// shown, they vanish, then all appear in other places and the one that was not shown has to be
// touched (docs/tasks/remember.md).
#pragma once

#include "tasks/family.h"

namespace engram::tasks {

// FindImposterColor{3,5,9}, FindImposterShape{3,5,9}, FindImposterShapeAndColor{3x2,3x3,5x3};
// -VLA-v0.
extern const Family kFindImposterColor;
extern const Family kFindImposterShape;
extern const Family kFindImposterShapeAndColor;

}  // namespace engram::tasks
