#pragma once
/// Draws a World off-screen. The only room that knows OpenGL.
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/world/world.hpp"

namespace pantin {

/// A picture: rows from the top, four bytes a pixel, sRGB.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;
};

enum class GlPath : std::uint8_t { automatic, surfaceless, device, osmesa };

struct RenderOptions {
  int width = 1280, height = 720;
  int samples = 4;  // MSAA; 0 or 1 for none, fewer if the driver has fewer
  bool shadows = true;
  GlPath path = GlPath::automatic;
};

/// Which way to OpenGL was taken and why the others were not.
struct GlReport {
  std::string path, renderer, version;  // empty when none works
  std::vector<std::string> refused;     // one line a path tried in vain
  int samples = 1;   // MSAA in use: what was asked for or the most that the driver offers
  std::string font;  // the file whose letters are used, or "built-in (ASCII only)"
};

/// One line of a legend.
struct LegendEntry {
  Vec3 colour;  // linear RGB
  std::string text;
};

/// What is written and drawn over the picture.
struct Overlay {
  /// A force that is drawn as an arrow from the point where it acts.
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
  std::vector<Arrow> forces;  // as long as those of contacts
  std::vector<Vec3> doubts;   // world, m: places that are ringed in the warning colour
  /// Where a contact went over a body.
  struct Trail {
    Entity body;
    std::vector<Vec3> points;              // in its mass-centre frame, m, the oldest first
    std::vector<std::size_t> starts = {};  // of points that no line leads to, rising
  };
  std::vector<Trail> trails;
};

/// What the marks of Overlay::joints mean, as far as this world can show them.
std::vector<LegendEntry> overlay_legend(const World& world);
/// The same for Overlay::contacts and Overlay::forces.
std::vector<LegendEntry> forces_legend(const World& world);

/// Owns a GL context and everything in it. Use from one thread at a time.
class Renderer {
 public:
  /// Errors carry one line for each way to OpenGL that was refused.
  static Result<std::unique_ptr<Renderer>> create(const RenderOptions& options);
  virtual ~Renderer() = default;

  /// What one picture shows.
  struct Shot {
    const World& world;
    std::span<const Pose> poses = {};  // by slot of World::bodies; empty: where the bodies are
    View view = {};
    const Overlay* overlay = nullptr;  // null: nothing over the picture
    bool wireframe = false;            // edges of the bodies' triangles, no faces
  };
  /// Draws into `out`, whose memory is used again. An automatic camera is framed anew for every
  /// picture: for a film, take framing_camera() once.
  virtual void draw(const Shot& shot, Image& out) = 0;
  /// Pictures are of this size from now on. Smaller ones cost nothing, so sizes may change from
  /// picture to picture. Letters stay as large as they are.
  virtual Result<Done> resize(int width, int height) = 0;
  virtual const GlReport& report() const = 0;
};

/// A camera that sees all bodies of the world in a picture of this shape (width / height), looking
/// the way `view` does. Shapes and cables are included, where paths and a swing may carry them, and
/// the ground below with the shadows if it is near. Planes are not, and height fields only around
/// the rest, unless there is nothing else. The result is not automatic.
Camera framing_camera(const World& world, const View& view, Real aspect);

}  // namespace pantin
