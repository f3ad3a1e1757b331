// What MuJoCo 2.2 and newer versions, 3.17 to 4, call differently. Versions are mjVERSION_HEADER's:
// 222 is 2.2.2, and 3017000 is 3.17.0.
#pragma once

#include <mujoco/mujoco.h>

namespace engram {

#if mjVERSION_HEADER >= 300

// Makes MuJoCo look at the explicit pairs of geoms alone. It finds no others in engram's scenes
// anyway, where contype and conaffinity are 0.
inline void collide_pairs_alone(mjModel& /*model*/) {}

// What collision functions fill.
using MujocoContact = mjPreContact;
inline const mjtNum* normal_of(const MujocoContact& contact) { return contact.normal; }

// The texture of a material's colour, or -1.
inline int& texture_of(const mjModel& model, int material) {
  return model.mat_texid[material * mjNTEXROLE + mjTEXROLE_RGB];
}
// Red, green and blue of each pixel.
inline const mjtByte* texture_pixels(const mjModel& model, int texture) {
  return model.tex_data + model.tex_adr[texture];
}
inline bool is_directional(const mjModel& model, int light) {
  return model.light_type[light] == mjLIGHT_DIRECTIONAL;
}

// Gives back what a call has left on the stack that an error ended.
inline void clear_stack(mjData& data) {
  data.pstack = 0;
  data.pbase = 0;
}

#else

inline void collide_pairs_alone(mjModel& model) { model.opt.collision = mjCOL_PAIR; }

using MujocoContact = mjContact;
inline const mjtNum* normal_of(const MujocoContact& contact) { return contact.frame; }
inline int& texture_of(const mjModel& model, int material) { return model.mat_texid[material]; }
inline const mjtByte* texture_pixels(const mjModel& model, int texture) {
  return model.tex_rgb + model.tex_adr[texture];
}
inline bool is_directional(const mjModel& model, int light) {
  return model.light_directional[light] != 0;
}
inline void clear_stack(mjData& data) { data.pstack = 0; }

#endif

}  // namespace engram
