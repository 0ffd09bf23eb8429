#pragma once
/// Shader programs, and their compilation.
#include <string>

#include "engine/base/result.hpp"
#include "engine/render/gl.hpp"

namespace pantin::detail {

/// Sources without the `version` line; `kFrameSource` is put before each.
extern const char* const kFrameSource;
extern const char* const kSolidVertex;
extern const char* const kRibbonVertex;
extern const char* const kDepthFragment;    // for the shadow map
extern const char* const kSurfaceFragment;  // solids, and cables with RIBBON defined
extern const char* const kScreenVertex;     // one triangle over the whole picture
extern const char* const kSkyFragment;
extern const char* const kGroundFragment;  // with NEAR defined: shadows too
extern const char* const kMergeFragment;
extern const char* const kOverlayVertex;
extern const char* const kOverlayFragment;

/// Compiles and links; `defines` are lines put before both shaders. The error quotes the driver's
/// log.
Result<GLuint> make_program(const Gl& gl, const std::string& defines, const char* vertex,
                            const char* fragment);

}  // namespace pantin::detail
