// engram: pictures and videos, for tools. Needs the library engram_media besides engram.
#pragma once

#include "media/canvas.h"
#include "media/overlay.h"
#include "media/png.h"
#include "media/video.h"
#include "render/document_source.h"
#include "render/egl_context.h"
