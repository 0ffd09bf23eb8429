#include "engine/render/context.hpp"

#include <array>
#include <cstdlib>

namespace pantin::detail {
namespace {

constexpr std::array<const char*, 4> kNames = {"auto", "surfaceless", "device", "osmesa"};
constexpr std::array kOrder = {GlPath::surfaceless, GlPath::device, GlPath::osmesa};

std::string text_of(const Gl& gl, GLenum what) {
  const GLubyte* text = gl.GetString(what);
  return text ? reinterpret_cast<const char*>(text) : "";
}

/// Empty, or why the context cannot be used.
std::string shortcoming(const Gl& gl) {
  GLint major = 0, minor = 0;
  gl.GetIntegerv(GL_MAJOR_VERSION, &major);
  gl.GetIntegerv(GL_MINOR_VERSION, &minor);
  if (major > 3 || (major == 3 && minor >= 3)) return {};
  return "OpenGL " + std::to_string(major) + "." + std::to_string(minor) +
         " found, 3.3 or later expected";
}

}  // namespace

const char* name_of(GlPath path) { return kNames[static_cast<std::size_t>(path)]; }

bool gl_path_from_name(std::string_view name, GlPath& path) {
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (name != kNames[i]) continue;
    path = static_cast<GlPath>(i);
    return true;
  }
  return false;
}

Result<std::unique_ptr<Context>> open_context(GlPath wish, const GlLibraries& libraries,
                                              GlReport& report) {
  if (const char* word = std::getenv("PANTIN_GL"); word && *word && wish == GlPath::automatic) {
    if (!gl_path_from_name(word, wish)) {
      report.refused.push_back("PANTIN_GL: found \"" + std::string(word) +
                               "\", expected auto, surfaceless, device or osmesa");
      return Error{report.refused.back()};
    }
  }
  for (GlPath path : kOrder) {
    if (wish != GlPath::automatic && wish != path) continue;
    auto opened =
        path == GlPath::osmesa ? open_osmesa(libraries.osmesa) : open_egl(path, libraries.egl);
    std::string why;
    if (opened) {
      why = shortcoming((*opened)->gl);
      if (why.empty()) {
        report.path = name_of(path);
        report.renderer = text_of((*opened)->gl, GL_RENDERER);
        report.version = text_of((*opened)->gl, GL_VERSION);
        return opened;
      }
    } else {
      why = opened.errors().front().message;
    }
    report.refused.push_back(std::string(name_of(path)) + ": " + why);
  }
  std::vector<Error> errors;
  for (const std::string& line : report.refused) errors.push_back({line});
  return errors;
}

}  // namespace pantin::detail
