#pragma once
/// Two-dimensional overlay of the picture: panels, text, lines.
#include <span>
#include <vector>

#include "engine/render/eye.hpp"
#include "engine/render/font.hpp"
#include "engine/render/renderer.hpp"

namespace pantin::detail {

struct OverlayVertex {
  float pixel[2];   // from the top left corner
  float local[2];   // in the atlas, or in pixels from the centre of the box
  float form[4];    // see the overlay shader
  float colour[4];  // sRGB and opacity
};

/// Colour and opacity of an overlay element.
struct Paint {
  Paint(Vec3 srgb, Real opaque = 1) : colour(srgb), opacity(opaque) {}
  Vec3 colour;   // sRGB
  Real opacity;  // 0..1
};

/// Quads, four vertices each, in painting order.
class OverlayList {
 public:
  explicit OverlayList(const Font& font) : font_(font) {}

  void clear() { vertices_.clear(); }
  std::span<const OverlayVertex> vertices() const { return vertices_; }

  void add_box(Vec3 middle, Vec3 half, Real radius, const Paint& paint);
  void add_line(Vec3 a, Vec3 b, Real width, const Paint& paint);
  void add_triangle(Vec3 a, Vec3 b, Vec3 c, const Paint& paint);
  void add_ring(Vec3 middle, Real radius, Real width, Vec3 colour);
  void add_text(Vec3 baseline, std::string_view utf8, Vec3 colour);

  /// Draws the lines of `overlay` on a panel at the top left, its legend on one at the bottom left.
  void add_labels(const Overlay& overlay, const Eye& eye);

 private:
  void add_quad(const float (&corners)[4][2], const float (&locals)[4][2], const float (&form)[4],
                const Paint& paint);

  const Font& font_;
  std::vector<OverlayVertex> vertices_;
};

}  // namespace pantin::detail
