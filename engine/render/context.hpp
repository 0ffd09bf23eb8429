#pragma once
/// Ways to an OpenGL 3.3 core context without a display: EGL surfaceless, an EGL device, OSMesa.
#include <memory>
#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/render/gl.hpp"
#include "engine/render/renderer.hpp"

namespace pantin::detail {

/// A context and its entry points. Objects made in it die with it.
class Context {
 public:
  virtual ~Context() = default;
  /// Binds the context to this thread; false if another thread has it.
  virtual bool make_current() = 0;
  virtual void release() = 0;

  Gl gl;
};

/// Where the libraries are looked for; tests name some that do not exist.
struct GlLibraries {
  const char* egl = "libEGL.so.1";
  const char* osmesa = "libOSMesa.so.8";
};

/// "auto", "surfaceless", "device", "osmesa".
const char* name_of(GlPath path);
/// False, and `path` untouched, for any other word.
bool gl_path_from_name(std::string_view name, GlPath& path);

/// One path, current on this thread when it works. The error is a clause without the path's name.
Result<std::unique_ptr<Context>> open_egl(GlPath path, const char* library);
Result<std::unique_ptr<Context>> open_osmesa(const char* library);

/// The first path that works, in the order surfaceless, device, OSMesa; or only `wish`, or the one
/// that the environment variable PANTIN_GL names when `wish` is automatic. Fills `report`; the
/// errors are its refusals.
Result<std::unique_ptr<Context>> open_context(GlPath wish, const GlLibraries& libraries,
                                              GlReport& report);

}  // namespace pantin::detail
