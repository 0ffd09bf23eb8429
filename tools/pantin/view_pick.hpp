#pragma once
// From the picture into the scene: which body is at a pixel, and where a point of it is drawn.
#include <optional>
#include <span>

#include "engine/render/bounds.hpp"
#include "engine/render/eye.hpp"
#include "engine/world/queries.hpp"
#include "engine/world/world.hpp"

namespace pantin::program {

using namespace detail;

/// A pixel of the picture that an eye sees.
struct SeenPixel {
  const Eye& eye;
  double x, y;  // from the left, from the top
};

/// The ray that the middle of a pixel shows, 1 m of it.
Ray ray_through(const SeenPixel& pixel);

/// A point on a body's surface.
struct Picked {
  Entity body;
  Vec3 point{0};   // world, as drawn
  Vec3 anchor{0};  // the same in the mass-centre frame
};

/// The nearest body that is drawn at a pixel, or else within a few pixels of it, so that thin ones
/// can be caught. The poses are those that were drawn; without those of all bodies there is none.
std::optional<Picked> pick(const PosedWorld& scene, const SeenPixel& pixel);

/// Where the ray through a pixel meets the plane through `point` that faces the eye.
Vec3 on_plane(const SeenPixel& pixel, Vec3 point);

}  // namespace pantin::program
