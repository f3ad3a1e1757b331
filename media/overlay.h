// Drawing of overlays (core/image/overlay.h) on images.
#pragma once

#include "core/image/overlay.h"
#include "media/canvas.h"

namespace engram {

// An empty overlay for an image of that many pixels.
Overlay make_overlay(int width, int height);

// Items of all tasks: the step, and the reward unless the environment variable
// MIKASA_DISABLE_REWARD_OVERLAY is set to anything but 0.
void add_step(Overlay& overlay, int step);
void add_reward(Overlay& overlay, double reward);

// Draws over the image that has its left top corner there; `overlay` was made for its size.
// `side`: the image's shorter side in pixels.
void draw_overlay(const Overlay& overlay, Point corner, int side, Canvas& canvas);

}  // namespace engram
