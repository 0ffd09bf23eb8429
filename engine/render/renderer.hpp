#pragma once
/// Draws a World off-screen. The only room that uses OpenGL.
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/world/world.hpp"

namespace pantin {

/// A picture: rows from the top, four bytes per pixel, sRGB.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;
};

enum class GlPath : std::uint8_t { automatic, surfaceless, device, osmesa };

struct RenderOptions {
  int width = 1280, height = 720;
  int samples = 4;  // MSAA; 0 or 1: none; reduced to what the driver supports
  bool shadows = true;
  GlPath path = GlPath::automatic;
};

/// The path to OpenGL in use, and why others were refused.
struct GlReport {
  std::string path, renderer, version;  // empty when none works
  std::vector<std::string> refused;     // one line for each failed path
  int samples = 1;   // MSAA in use: the number requested, or the most that the driver offers
  std::string font;  // the font file, or "built-in (ASCII only)"
};

/// One line of a legend.
struct LegendEntry {
  Vec3 colour;  // linear RGB
  std::string text;
};

/// Text and marks over the picture.
struct Overlay {
  /// A force, drawn as an arrow from its point of application.
  struct Arrow {
    Vec3 at{0};     // world, m
    Vec3 force{0};  // world, N
  };
  std::vector<std::string> lines;   // top left
  std::string alarm;                // below them, in red
  std::vector<LegendEntry> legend;  // bottom left
  bool joints =
      false;  // marks: joints and their ranges, pins, slack cables, joint drives, contacts
  bool contacts = false;      // contacts and their forces alone
  std::vector<Arrow> forces;  // scaled like those of contacts
  std::vector<Vec3> doubts;   // world, m: places of findings, ringed in the warning colour
  /// The path of a contact on a body.
  struct Trail {
    Entity body;
    std::vector<Vec3> points;              // in its mass-centre frame, m, the oldest first
    std::vector<std::size_t> starts = {};  // ascending indices of points that begin a new line
  };
  std::vector<Trail> trails;
};

/// The meaning of the marks of Overlay::joints that this World can show.
std::vector<LegendEntry> overlay_legend(const World& world);
/// The same for Overlay::contacts and Overlay::forces.
std::vector<LegendEntry> forces_legend(const World& world);

/// Owns a GL context and all its objects. Use it from one thread at a time.
class Renderer {
 public:
  /// Errors contain one line for each refused path to OpenGL.
  static Result<std::unique_ptr<Renderer>> create(const RenderOptions& options);
  virtual ~Renderer() = default;

  /// The content of one picture.
  struct Shot {
    const World& world;
    std::span<const Pose> poses = {};  // by slot of World::bodies; empty: the present poses
    View view = {};
    const Overlay* overlay = nullptr;  // null: no overlay
    bool wireframe = false;            // edges of the bodies' triangles only
    // By slot of World::bodies, linear RGB; bodies beyond have the colours of their materials, or
    // of a palette by body where they name none.
    std::span<const Vec3> colours = {};
  };
  /// Draws into `out` and reuses its memory. An automatic camera is framed for every picture: for a
  /// film, call framed_view() once.
  virtual void draw(const Shot& shot, Image& out) = 0;
  /// Sets the size of pictures. Reducing it costs nothing, so sizes may alternate. The size of
  /// letters is unchanged.
  virtual Result<Done> resize(int width, int height) = 0;
  virtual const GlReport& report() const = 0;
};

/// A camera that sees all bodies of the world in a picture of this aspect ratio (width / height),
/// in the viewing direction of `view`. It includes shapes and cables, the extent of their paths and
/// swings, and the nearby ground with shadows. Planes are excluded, and height fields count only
/// near other objects, unless there are no others. The result is not automatic. A camera that is
/// left at its default direction looks from above where a body is in a cavity.
Camera framing_camera(const World& world, const View& view, Real aspect);

/// The height of the ground of `view`. Where that is not a number: the highest level fixed plane;
/// without planes 0, or the lowest point of all that framing_camera() sees if it is below.
Real ground_height_of(const World& world, const View& view);

/// `view` with the height of its ground, and with a framing camera if its own is automatic.
View framed_view(const World& world, const View& view, Real aspect);

/// A camera at the same distance from the same target, in the direction `way` (unit) from it.
Camera seen_from(Vec3 way, const Camera& from);

}  // namespace pantin
