#pragma once
/// The uniforms of one picture, shared by all shaders, and the regions to draw.
#include <cstdint>

#include "engine/render/gather.hpp"

namespace pantin::detail {

/// Laid out as the std140 block `Frame` of the shaders. Positions are relative to the eye.
struct FrameBlock {
  float clip[4][4];   // rows: world to clip space, with the picture's top at y = -1
  float light[3][4];  // rows: world to the shadow map, 0..1 an axis
  float sun[4];       // unit, to the light; w: side of a shadow texel, m
  float sunlight[4];  // colour times strength; w: size of the shadow map in texels
  float sky[4];       // ambient from above; w: size of a pixel at unit depth, m
  float soil[4];      // ambient from below; w: height of the ground
  float ray[3][4];    // ray through the top left corner; its increment per pixel to the right, and
                      // down
  float horizon[4];   // squared display colours: sky at the horizon; w: size of a tile, m
  float zenith[4];    // sky above; w: distance at which the ground fades, m
  float tiles[4][4];  // squared display colours: light and dark tile in the sun, in shadow
  float shade[4];     // ground positions (x, z) to the contact-shade map: scale, offset
  float origin[4];    // ground positions to tiles: offset x, z; centre of the fading: x, z
  float viewport[4];  // pixels to clip space: scale x, y
};

/// Pixels [x0, x1) x [y0, y1), y from the top.
struct PixelRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool empty() const { return x1 <= x0 || y1 <= y0; }
  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
};

struct Frame {
  FrameBlock block;
  PixelRect solids;       // region of bodies and cables
  PixelRect near_ground;  // region of possible shadows on the ground; within the rows of the ground
  int ground_row = 0;     // first row with ground; the height if there is none
  Vec3 shade_low{0}, shade_high{0};  // ground around the bodies, world
  bool clips_ground = false;         // something drawn extends below the ground
};

inline constexpr int kShadowSize = 1024;  // texels

Frame make_frame(const View& view, const Eye& eye, const DrawList& list);

inline constexpr int kShadeSize = 128;  // texels per side of the contact-shade map
inline constexpr Real kShadeReach = 4;  // radii of a ball; beyond it its shade is invisible
/// Whether a ball, with its centre at this height, shades the ground visibly.
inline bool shades_ground(const Ball& ball, Real height) {
  return height + ball.radius >= 0 && height <= 8 * ball.radius;
}

/// The part of the ground that a contact-shade map covers, world.
struct GroundPatch {
  Vec3 low{0}, high{0};  // m; only x and z are used
  Real height = 0;       // m
};
/// Sky visibility of the ground, 0..255, rows along z: the cosine-weighted fraction of the sky that
/// balls do not occlude; each occludes r^2 h / d^3.
void shade_ground(std::span<const Ball> balls, const GroundPatch& ground,
                  std::vector<std::uint8_t>& to);

/// The displayed colour of a linear one, sRGB, 0..1: tone curve and transfer curve of the shaders.
Vec3 display_colour(Vec3 linear);
/// The sRGB transfer curve alone.
Vec3 srgb(Vec3 linear);

}  // namespace pantin::detail
