#include "render/egl/gl_functions.h"

namespace engram {

const char* load_gl(void (*(*find)(const char*))(), Gl& gl) {
#define ENGRAM_GL_LOAD(type, name)                    \
  gl.name = reinterpret_cast<type>(find("gl" #name)); \
  if (gl.name == nullptr) return "gl" #name;
  ENGRAM_GL_FUNCTIONS(ENGRAM_GL_LOAD)
#undef ENGRAM_GL_LOAD
  return nullptr;
}

}  // namespace engram
