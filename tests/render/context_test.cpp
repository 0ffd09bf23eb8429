#include "engine/render/context.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>

using namespace pantin;
using namespace pantin::detail;

namespace {

/// Sets PANTIN_GL for one scope.
class GlWish {
 public:
  explicit GlWish(const char* word) { setenv("PANTIN_GL", word, 1); }
  ~GlWish() { unsetenv("PANTIN_GL"); }
};

constexpr GlLibraries kNoEgl{"libEGL-of-nobody.so.1", "libOSMesa.so.8"};
constexpr GlLibraries kNothing{"libEGL-of-nobody.so.1", "libOSMesa-of-nobody.so.8"};

}  // namespace

TEST_CASE("paths to OpenGL have names, and other words are refused") {
  for (GlPath path : {GlPath::automatic, GlPath::surfaceless, GlPath::device, GlPath::osmesa}) {
    GlPath read = GlPath::automatic;
    CHECK(gl_path_from_name(name_of(path), read));
    CHECK(read == path);
  }
  GlPath untouched = GlPath::device;
  CHECK_FALSE(gl_path_from_name("OSMesa", untouched));
  CHECK_FALSE(gl_path_from_name("", untouched));
  CHECK(untouched == GlPath::device);
}

TEST_CASE("a forced path is taken or refused in one line of its own") {
  for (GlPath path : {GlPath::surfaceless, GlPath::device, GlPath::osmesa}) {
    GlReport report;
    auto context = open_context(path, {}, report);
    if (!context) {
      WARN("not on this machine: " << context.errors().front().message);
      CHECK(report.refused.size() == 1);
      CHECK(context.errors().front().message.rfind(std::string(name_of(path)) + ": ", 0) == 0);
      continue;
    }
    CHECK(report.path == name_of(path));
    CHECK_FALSE(report.renderer.empty());
    CHECK_FALSE(report.version.empty());
    CHECK(report.refused.empty());
    GLint major = 0;
    (*context)->gl.GetIntegerv(GL_MAJOR_VERSION, &major);
    CHECK(major >= 3);
  }
}

TEST_CASE("without EGL the chain falls to OSMesa and says why") {
  GlReport report;
  auto context = open_context(GlPath::automatic, kNoEgl, report);
  REQUIRE(report.refused.size() >= 2);
  CHECK(report.refused[0].rfind("surfaceless: libEGL-of-nobody.so.1", 0) == 0);
  CHECK(report.refused[1].rfind("device: libEGL-of-nobody.so.1", 0) == 0);
  if (context)
    CHECK(report.path == "osmesa");
  else
    WARN("not on this machine: " << context.errors().back().message);
}

TEST_CASE("without any library every path is refused in one line") {
  GlReport report;
  auto context = open_context(GlPath::automatic, kNothing, report);
  REQUIRE_FALSE(context);
  CHECK(context.errors().size() == 3);
  CHECK(report.refused.size() == 3);
  CHECK(report.path.empty());
  CHECK(report.refused[2].rfind("osmesa: libOSMesa-of-nobody.so.8", 0) == 0);
}

TEST_CASE("PANTIN_GL forces a path, the option has the last word, nonsense is refused") {
  {
    const GlWish wish("osmesa");
    GlReport report;
    CHECK_FALSE(open_context(GlPath::automatic, kNothing, report));
    CHECK(report.refused.size() == 1);
    CHECK(report.refused[0].rfind("osmesa: ", 0) == 0);
  }
  {
    const GlWish wish("osmesa");
    GlReport report;
    CHECK_FALSE(open_context(GlPath::device, kNothing, report));
    CHECK(report.refused[0].rfind("device: ", 0) == 0);
  }
  {
    const GlWish wish("vulkan");
    GlReport report;
    auto context = open_context(GlPath::automatic, {}, report);
    REQUIRE_FALSE(context);
    CHECK(context.errors().front().message ==
          "PANTIN_GL: found \"vulkan\", expected auto, surfaceless, device or osmesa");
  }
}
