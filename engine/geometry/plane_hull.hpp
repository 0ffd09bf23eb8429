#pragma once
/// Convex hulls of points in a plane.
#include <vector>

#include "engine/base/math.hpp"

namespace pantin::detail {

/// The corners of the convex hull of points with z = 0, anticlockwise, starting at the least x. No
/// corner turns by less than 1e-9 rad, and no two are closer than 1e-12 of the points' extent.
/// Empty if the points are collinear.
std::vector<Vec3> plane_hull(std::vector<Vec3> points);

}  // namespace pantin::detail
