// engram: images and videos, for tools. Needs the library engram_media besides engram.
#pragma once

#include "media/canvas.h"
#include "media/overlay.h"
#include "media/png.h"
#include "media/video.h"
#include "render/egl/context.h"
#include "render/make_renderer.h"
