#pragma once
// From the picture into the scene: which body is at a pixel, and where a point of it is drawn.
#include <optional>
#include <span>

#include "engine/render/eye.hpp"
#include "engine/world/queries.hpp"
#include "engine/world/world.hpp"

namespace pantin::program {

using namespace detail;

/// The ray that the middle of a pixel shows, 1 m of it; x from the left, y from the top.
Ray ray_through(const Eye& eye, double x, double y);

/// A point on a body's surface.
struct Picked {
  Entity body;
  Vec3 point{0};   // world, as drawn
  Vec3 anchor{0};  // the same in the mass-centre frame
};

/// The nearest body that is drawn at a pixel, or else within a few pixels of it, so that thin ones
/// can be caught. `poses` are those that were drawn, by slot.
std::optional<Picked> pick(const World& world, std::span<const Pose> poses, const Eye& eye,
                           double x, double y);

/// Where the ray through a pixel meets the plane through `point` that faces the eye.
Vec3 on_plane(const Eye& eye, Vec3 point, double x, double y);

}  // namespace pantin::program
