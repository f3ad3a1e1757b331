// engram: pictures and videos, for tools. Needs the library engram_media besides engram.
#pragma once

#include "render/canvas.h"
#include "render/document_source.h"
#include "render/egl_context.h"
#include "render/overlay.h"
#include "render/png.h"
#include "render/video.h"
