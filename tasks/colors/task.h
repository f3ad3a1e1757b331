// BunchOfColors, SeqOfColors and ChainOfColors: coloured cubes are shown together or one by one,
// and have to be touched among nine; in the VLA tasks the button in the middle is pressed then
// (docs/tasks/colors.md).
#pragma once

#include "tasks/family.h"

namespace engram::tasks {

// {Bunch,Seq,Chain}OfColors{3,5,7}-VLA-v0 and -Long-VLA-v0, and the RL tasks
// {Bunch,Seq,Chain}OfColors{3,5,7}-v0.
extern const Family kSeqOfColors;
extern const Family kChainOfColors;
extern const Family kBunchOfColors;

}  // namespace engram::tasks
