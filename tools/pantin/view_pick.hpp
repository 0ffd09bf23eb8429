#pragma once
// Picking: the body at a pixel, and the pixel of a body's point.
#include <optional>
#include <span>

#include "engine/render/bounds.hpp"
#include "engine/render/eye.hpp"
#include "engine/world/queries.hpp"
#include "engine/world/world.hpp"

namespace pantin::program {

using namespace detail;

/// A pixel of the picture of an eye.
struct SeenPixel {
  const Eye& eye;
  double x, y;  // from the left, from the top
};

/// The ray through the centre of a pixel, 1 m long.
Ray ray_through(const SeenPixel& pixel);

/// A point on a body's surface.
struct Picked {
  Entity body;
  Vec3 point{0};   // world, as drawn
  Vec3 anchor{0};  // the same in the mass-centre frame
};

/// The nearest body drawn at a pixel, or within a few pixels of it, so that thin bodies can be
/// picked. Uses the drawn poses; none if these are incomplete.
std::optional<Picked> pick(const PosedWorld& scene, const SeenPixel& pixel);

/// The intersection of the ray through a pixel with the plane through `point` perpendicular to the
/// view.
Vec3 on_plane(const SeenPixel& pixel, Vec3 point);

}  // namespace pantin::program
