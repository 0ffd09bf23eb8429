#pragma once
/// Opens an OpenGL 3.3 core context without a display: EGL surfaceless, an EGL device, OSMesa.
#include <memory>
#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/render/gl.hpp"
#include "engine/render/renderer.hpp"

namespace pantin::detail {

/// A context and its entry points. Objects created in it are destroyed with it.
class Context {
 public:
  virtual ~Context() = default;
  /// Binds the context to this thread; returns false if another thread holds it.
  virtual bool make_current() = 0;
  virtual void release() = 0;

  Gl gl;
};

/// Names of the libraries; tests pass names that do not exist.
struct GlLibraries {
  const char* egl = "libEGL.so.1";
  const char* osmesa = "libOSMesa.so.8";
};

/// "auto", "surfaceless", "device", "osmesa".
const char* name_of(GlPath path);
/// Returns false, and leaves `path` unchanged, for any other word.
bool gl_path_from_name(std::string_view name, GlPath& path);

/// Opens one path and makes it current on this thread. The error is a clause without the path's
/// name.
Result<std::unique_ptr<Context>> open_egl(GlPath path, const char* library);
Result<std::unique_ptr<Context>> open_osmesa(const char* library);

/// The first path that works, in the order surfaceless, device, OSMesa; or only `wish`, or the one
/// named by the environment variable PANTIN_GL if `wish` is automatic. Fills `report`; the errors
/// are the reasons of the refused paths.
Result<std::unique_ptr<Context>> open_context(GlPath wish, const GlLibraries& libraries,
                                              GlReport& report);

}  // namespace pantin::detail
