#include "engine/render/gl.hpp"

namespace pantin::detail {

const char* load(Gl& gl, GlLookUp look_up) {
#define PANTIN_GL_LOAD(type, name)                       \
  gl.name = reinterpret_cast<type>(look_up("gl" #name)); \
  if (!gl.name) return "gl" #name;
  PANTIN_GL_ENTRY_POINTS(PANTIN_GL_LOAD)
#undef PANTIN_GL_LOAD
  return nullptr;
}

}  // namespace pantin::detail
