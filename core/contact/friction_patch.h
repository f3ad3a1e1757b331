// Friction patches: contacts of a pair with the same normal, and the anchors at which its bodies
// stick to one another, carried over from substep to substep as in PhysX.
#pragma once

#include "core/collision/contact_pair.h"
#include "core/collision/contact_point.h"
#include "core/contact/contact_block.h"
#include "core/math/frame.h"

namespace engram {

// Groups the points of a pair into patches and sets points, normals and anchors of `specs`; updates
// the pair's memory, one patch for each. `a`, `b`: poses of the centres of mass. Returns the number
// of patches.
int build_patches(const ContactPoints& points, const Frame& a, const Frame& b, ContactPair& pair,
                  std::array<PatchSpec, ContactPair::kMaxPatches>& specs);

}  // namespace engram
