// The wood of the tables: grain along the board, painted once.
#pragma once

#include "render/cpu/frame_data.h"

namespace engram::cpu {

// The texture of all tables: painted on first use, never freed.
WoodTexture wood_texture();

}  // namespace engram::cpu
