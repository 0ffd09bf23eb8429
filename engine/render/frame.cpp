#include "engine/render/frame.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

namespace pantin::detail {
namespace {

constexpr Real kInfinity = std::numeric_limits<Real>::infinity();
constexpr Real kAmbient = 0.55;  // fraction of the sky's light that reaches a point among other
                                 // objects
constexpr Real kLightTile = 0.33, kDarkTile = 0.25;  // albedo
constexpr Real kShadowBlur = 3;                      // texels, width of a shadow's penumbra

void store(Vec3 from, Real w, float* to) {
  for (int k = 0; k < 3; ++k) to[k] = static_cast<float>(from[k]);
  to[3] = static_cast<float>(w);
}

Vec3 direction_of(const Light& light) {
  const Real length = glm::length(light.direction);
  return length > 0 ? light.direction / length : Vec3{0, -1, 0};
}

void set_clip(FrameBlock& block, const Eye& eye, const DrawList& list) {
  Real low = kInfinity, high = 0;
  for (const Hulls* hulls : {&list.solids_around, &list.grounds}) {
    for (const Ball& b : hulls->balls) {
      const Real depth = eye.depth(b.centre);
      low = std::min(low, depth - b.radius), high = std::max(high, depth + b.radius);
    }
  }
  const Real far = std::max(high * 1.01, 1e-3);
  const Real near = std::clamp(low * 0.99, far * 1e-4, far * 0.99);
  const Real a = (far + near) / (far - near), b = -2 * far * near / (far - near);
  store(eye.right / eye.tan_x, 0, block.clip[0]);
  store(-eye.up / eye.tan_y, 0, block.clip[1]);
  store(a * eye.forward, b, block.clip[2]);
  store(eye.forward, 0, block.clip[3]);
}

/// Fits the shadow map around moving objects, and around fixed ones unless they are much larger,
/// like a floor. The fit grows in steps and moves by whole texels, so that shadow edges do not
/// shimmer.
void set_light(FrameBlock& block, const View& view, const Eye& eye, const DrawList& list) {
  const Vec3 way = direction_of(view.light);
  const Vec3 aside = std::abs(way.y) < 0.99 ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
  const Vec3 right = glm::normalize(glm::cross(way, aside));
  const Vec3 axes[3] = {right, glm::cross(right, way), way};

  Vec3 low{kInfinity}, high{-kInfinity};
  const auto take = [&](const Ball& b) {
    const Vec3 c{glm::dot(axes[0], b.centre), glm::dot(axes[1], b.centre),
                 glm::dot(axes[2], b.centre)};
    low = glm::min(low, c - b.radius), high = glm::max(high, c + b.radius);
  };
  for (const Ball& b : list.movers) take(b);
  const Vec3 moving_low = low, moving_size = high - low;
  const Real reach = std::max({moving_size.x, moving_size.y, moving_size.z});
  for (const Ball& b : list.solids_around.balls) {
    const Vec3 c{glm::dot(axes[0], b.centre), glm::dot(axes[1], b.centre),
                 glm::dot(axes[2], b.centre)};
    const Vec3 middle = moving_low + moving_size / 2.0;
    if (list.movers.empty() || glm::length(c - middle) + b.radius < 2 * reach) take(b);
  }
  if (list.movers.empty() && list.solids_around.balls.empty())
    for (const Ball& b : list.grounds.balls) take(b);
  if (!(low.x <= high.x)) low = Vec3{-1}, high = Vec3{1};

  Real texel = 0;
  for (int k = 0; k < 3; ++k) {
    const Real size = std::max(high[k] - low[k], 1e-3);
    const Real step = std::exp2(std::ceil(std::log2(size))) / 8;
    const Real side = (std::ceil(size * 1.02 / step) + 1) * step;
    const Real grain = side / kShadowSize;
    const Real middle = std::round((low[k] + high[k]) / 2 / grain) * grain;
    store(axes[k] / side, (glm::dot(axes[k], eye.position) - middle) / side + 0.5, block.light[k]);
    if (k < 2) texel = std::max(texel, grain);
  }
  store(-way, texel, block.sun);
  store(view.light.strength * view.light.colour, kShadowSize, block.sunlight);
}

void set_colours(FrameBlock& block, const View& view, const Eye& eye) {
  const Light& light = view.light;
  store(kAmbient * light.sky, eye.pixel(), block.sky);
  store(kAmbient * light.ground, view.ground_height - eye.position.y, block.soil);
  const auto squared = [](Vec3 shown) { return shown * shown; };
  // The largest 1, 2 or 5 times a power of ten that is below a sixth of the distance.
  const Real wish = eye.distance / 6;
  const Real ten = std::pow(10, std::floor(std::log10(wish)));
  const Real tile = wish < 2 * ten ? ten : wish < 5 * ten ? 2 * ten : 5 * ten;
  store(squared(display_colour(1.62 * light.sky)), tile, block.horizon);
  store(squared(display_colour(1.15 * light.sky * light.sky)), 4.5 * eye.distance, block.zenith);
  const Real incidence = std::max(-direction_of(light).y, 0.0);
  const Vec3 sun = light.strength * light.colour * incidence / kPi, ambient = kAmbient * light.sky;
  store(squared(display_colour(kLightTile * (sun + ambient))), 0, block.tiles[0]);
  store(squared(display_colour(kDarkTile * (sun + ambient))), 0, block.tiles[1]);
  store(squared(display_colour(kLightTile * ambient)), 0, block.tiles[2]);
  store(squared(display_colour(kDarkTile * ambient)), 0, block.tiles[3]);
}

void set_rays(FrameBlock& block, const Eye& eye) {
  // The pattern repeats after two tiles; whole periods are dropped to keep precision far from the
  // origin.
  const Real pair = 2 * static_cast<Real>(block.horizon[3]);
  const Vec3 target = eye.distance * eye.forward;
  block.origin[0] = static_cast<float>(eye.position.x - pair * std::floor(eye.position.x / pair));
  block.origin[1] = static_cast<float>(eye.position.z - pair * std::floor(eye.position.z / pair));
  block.origin[2] = static_cast<float>(target.x);
  block.origin[3] = static_cast<float>(target.z);
  block.viewport[0] = 2 / static_cast<float>(eye.width);
  block.viewport[1] = 2 / static_cast<float>(eye.height);
  const Vec3 right = 2 * eye.tan_x / eye.width * eye.right;
  const Vec3 down = -2 * eye.tan_y / eye.height * eye.up;
  store(eye.forward - eye.tan_x * eye.right + eye.tan_y * eye.up, 0, block.ray[0]);
  store(right, 0, block.ray[1]);
  store(down, 0, block.ray[2]);
}

void unite(PixelRect& rect, const PixelRect& own) {
  if (own.empty()) return;
  if (rect.empty()) {
    rect = own;
    return;
  }
  rect = {std::min(rect.x0, own.x0), std::min(rect.y0, own.y0), std::max(rect.x1, own.x1),
          std::max(rect.y1, own.y1)};
}

/// In pixels, not clipped to the picture.
struct PixelBounds {
  Real low[2] = {kInfinity, kInfinity}, high[2] = {-kInfinity, -kInfinity};

  void add(const Eye& eye, const Ball& ball) {
    const Real depth = eye.depth(ball.centre);
    const Vec3 d = ball.centre - eye.position;
    const Real middle[2] = {glm::dot(eye.right, d), -glm::dot(eye.up, d)};
    const Real tan[2] = {eye.tan_x, eye.tan_y};
    const int size[2] = {eye.width, eye.height};
    // The outer one of the nearest and the farthest.
    const auto pixel = [&](int axis, Real edge, Real z) {
      return (1 + edge / (z * tan[axis])) / 2 * size[axis];
    };
    const Real nearest = depth - ball.radius, farthest = depth + ball.radius;
    for (int k = 0; k < 2; ++k) {
      const Real from = middle[k] - ball.radius, to = middle[k] + ball.radius;
      low[k] = std::min(low[k], pixel(k, from, from > 0 ? farthest : nearest));
      high[k] = std::max(high[k], pixel(k, to, to > 0 ? nearest : farthest));
    }
  }
};

/// Extends `rect` by the projection of a hull, even if all its balls are outside the picture; by
/// the whole picture if the hull crosses the plane of the eye.
void take(PixelRect& rect, const Eye& eye, std::span<const Ball> hull, int margin) {
  PixelBounds bounds;
  std::size_t behind = 0;
  bool is_cut = false;
  for (const Ball& b : hull) {
    const Real depth = eye.depth(b.centre);
    if (depth + b.radius <= 0)
      ++behind;
    else if (depth - b.radius <= 1e-3 * eye.distance)
      is_cut = true;
    else
      bounds.add(eye, b);
  }
  if (behind == hull.size()) return;
  if (behind > 0 || is_cut) {
    rect = {0, 0, eye.width, eye.height};
    return;
  }
  const auto kept = [](Real pixel, int size) { return std::clamp(pixel, Real(0), Real(size)); };
  const auto low = [&](int axis, int size) {
    return static_cast<int>(std::floor(kept(bounds.low[axis] - margin, size)));
  };
  const auto high = [&](int axis, int size) {
    return static_cast<int>(std::ceil(kept(bounds.high[axis] + margin, size)));
  };
  unite(rect, {low(0, eye.width), low(1, eye.height), high(0, eye.width), high(1, eye.height)});
}

/// The path of sunlight in the view.
struct Sunlight {
  const Eye& eye;
  Vec3 direction;  // unit, world, from the sun
};

/// Adds the shadow of a hull on the ground.
void take_shadow(Frame& frame, const Sunlight& light, std::span<const Ball> hull, Real ground) {
  const Eye& eye = light.eye;
  const Vec3 sun = light.direction;
  if (sun.y > -0.02) {  // a sun near the horizon: shadows everywhere
    frame.near_ground = {0, 0, eye.width, eye.height};
    return;
  }
  std::array<Ball, kMostBalls> shadow;
  const Real blur = kShadowBlur * frame.block.sun[3];
  std::transform(hull.begin(), hull.end(), shadow.begin(), [&](const Ball& b) {
    const Real way = std::max(b.centre.y - ground, 0.0) / -sun.y;
    return Ball{{b.centre.x + way * sun.x, ground, b.centre.z + way * sun.z},
                b.radius / -sun.y + blur};
  });
  take(frame.near_ground, eye, std::span(shadow).first(hull.size()), 2);
}

/// Adds the projection of a hull straight down on the ground.
void take_feet(Frame& frame, const Eye& eye, std::span<const Ball> hull, Real ground) {
  std::array<Ball, kMostBalls> feet;
  std::transform(hull.begin(), hull.end(), feet.begin(), [&](const Ball& b) {
    return Ball{{b.centre.x, ground, b.centre.z}, 0};
  });
  take(frame.near_ground, eye, std::span(feet).first(hull.size()), 2);
}

/// Finds the part of the ground where sun shadows and contact shade may fall.
void set_ground(Frame& frame, const View& view, const Eye& eye, const DrawList& list) {
  frame.ground_row = eye.height;
  if (!view.ground || eye.position.y <= view.ground_height) return;
  const auto rises = [&](int row) {
    return eye.forward.y + eye.up.y * eye.tan_y * (1 - 2 * (row + 0.5) / eye.height) > -1e-6;
  };
  frame.ground_row = 0;
  while (frame.ground_row < eye.height && rises(frame.ground_row)) ++frame.ground_row;

  const Sunlight sun{eye, direction_of(view.light)};
  const auto lowest = [&](const Ball& b) { return b.centre.y - b.radius - view.ground_height; };
  const auto highest = [&](const Ball& b) { return b.centre.y + b.radius - view.ground_height; };
  frame.shade_low = Vec3{kInfinity}, frame.shade_high = Vec3{-kInfinity};
  for (const Hulls* hulls : {&list.solids_around, &list.grounds})
    for (const Ball& b : hulls->balls) frame.clips_ground |= lowest(b) < 0;
  for (std::size_t i = 0; i < list.solids_around.size(); ++i) {
    const std::span<const Ball> hull = list.solids_around[i];
    if (std::any_of(hull.begin(), hull.end(), [&](const Ball& b) { return highest(b) >= 0; }))
      take_shadow(frame, sun, hull, view.ground_height);
  }
  // A margin, because a texel at the border of the map extends beyond the shade.
  const Real margin = 0.02 * eye.distance;
  for (const Ball& b : list.fillings) {
    const Real height = b.centre.y - view.ground_height, wide = kShadeReach * b.radius + margin;
    if (!shades_ground(b, height)) continue;
    const Vec3 foot{b.centre.x, view.ground_height, b.centre.z};
    frame.shade_low = glm::min(frame.shade_low, foot - wide);
    frame.shade_high = glm::max(frame.shade_high, foot + wide);
    const Ball shade{foot, wide};
    take(frame.near_ground, eye, {&shade, 1}, 2);
  }
  // Grounds cast no contact shade, which would cover everything around.
  for (std::size_t i = 0; i < list.grounds.size(); ++i) {
    take_feet(frame, eye, list.grounds[i], view.ground_height);
    take_shadow(frame, sun, list.grounds[i], view.ground_height);
  }
  if (!(frame.shade_low.x < frame.shade_high.x))
    frame.shade_low = Vec3{-1}, frame.shade_high = Vec3{1};
  frame.near_ground.y0 = std::max(frame.near_ground.y0, frame.ground_row);
}

}  // namespace

Vec3 srgb(Vec3 linear) {
  Vec3 shown;
  for (int k = 0; k < 3; ++k) {
    const Real c = std::clamp(linear[k], 0.0, 1.0);
    shown[k] = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
  }
  return shown;
}

Vec3 display_colour(Vec3 linear) {
  const Vec3 c = 0.62 * linear;  // same tone curve as tone() in the shaders
  return srgb(c * (2.51 * c + 0.03) / (c * (2.43 * c + 0.59) + 0.14));
}

Frame make_frame(const View& view, const Eye& eye, const DrawList& list) {
  Frame frame;
  std::memset(&frame.block, 0, sizeof frame.block);
  set_clip(frame.block, eye, list);
  set_light(frame.block, view, eye, list);
  set_colours(frame.block, view, eye);
  set_rays(frame.block, eye);
  for (const Hulls* hulls : {&list.solids_around, &list.grounds})
    for (std::size_t i = 0; i < hulls->size(); ++i) take(frame.solids, eye, (*hulls)[i], 3);
  set_ground(frame, view, eye, list);
  // Mesa clips by the distance that a shader writes even if clipping is disabled.
  frame.block.viewport[2] = frame.clips_ground ? frame.block.soil[3] : -1e30f;
  if (frame.shade_low.x < frame.shade_high.x) {
    const Vec3 size = frame.shade_high - frame.shade_low;
    const Vec3 from = eye.position - frame.shade_low;
    const Real numbers[4] = {1 / size.x, 1 / size.z, from.x / size.x, from.z / size.z};
    for (int k = 0; k < 4; ++k) frame.block.shade[k] = static_cast<float>(numbers[k]);
  }
  return frame;
}

}  // namespace pantin::detail
