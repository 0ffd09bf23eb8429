#pragma once
/// The numbers of one picture that all shaders share, and where on it there is something to do.
#include <cstdint>

#include "engine/render/gather.hpp"

namespace pantin::detail {

/// Laid out as the std140 block `Frame` of the shaders. Positions are relative to the eye.
struct FrameBlock {
  float clip[4][4];   // rows: world to clip space, the picture's top at y = -1
  float light[3][4];  // rows: world to the shadow map, 0..1 an axis
  float sun[4];       // unit, to the light; w: side of a shadow texel, m
  float sunlight[4];  // colour times strength; w: size of the shadow map in texels
  float sky[4];       // ambient from above; w: size of a pixel at unit depth, m
  float soil[4];      // ambient from below; w: height of the ground
  float ray[3][4];    // way through the top left corner, its change a pixel right, a pixel down
  float horizon[4];   // squares of display colours: sky at the horizon; w: size of a tile, m
  float zenith[4];    // sky above; w: distance at which the ground fades, m
  float tiles[4][4];  // squares of display colours: light and dark tile in the sun, in shadow
  float shade[4];     // positions on the ground (x, z) to the map of contact shade: scale, offset
  float origin[4];    // positions on the ground to tiles: offset x, z; middle of the fading: x, z
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
  PixelRect solids;       // all that is drawn of bodies and cables
  PixelRect near_ground;  // where shadows may fall on the ground; within the rows of the ground
  int ground_row = 0;     // first row that shows ground; the height if none does
  Vec3 shade_low{0}, shade_high{0};  // ground around the bodies, world
  bool clips_ground = false;         // something drawn reaches below the ground
};

inline constexpr int kShadowSize = 1024;  // texels

Frame make_frame(const View& view, const Eye& eye, const DrawList& list);

inline constexpr int kShadeSize = 128;  // texels a side of the map of contact shade
inline constexpr Real kShadeReach = 4;  // radii of a ball; farther its shade is too faint to see
/// Whether a ball with its centre that high above the ground takes visible light from it.
inline bool shades_ground(const Ball& ball, Real height) {
  return height + ball.radius >= 0 && height <= 8 * ball.radius;
}

/// The part of the ground that a map of contact shade covers, world.
struct GroundPatch {
  Vec3 low{0}, high{0};  // m; their x and z count
  Real height = 0;       // m
};
/// How open the ground is to the sky, 0..255, rows along z: the cosine-weighted part of the sky
/// that balls leave free, r^2 h / d^3 of it being taken by each.
void shade_ground(std::span<const Ball> balls, const GroundPatch& ground,
                  std::vector<std::uint8_t>& to);

/// A linear colour as it is shown, sRGB, 0..1: the tone curve and the transfer curve of the
/// shaders.
Vec3 display_colour(Vec3 linear);
/// The sRGB transfer curve alone.
Vec3 srgb(Vec3 linear);

}  // namespace pantin::detail
