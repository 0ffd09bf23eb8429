#pragma once
/// Convex hulls of points in a plane.
#include <vector>

#include "engine/base/math.hpp"

namespace pantin::detail {

/// The corners of the convex hull of points with z = 0, anticlockwise, from the one of the least x
/// on. None turns by less than 1e-9 rad, and no two are nearer to one another than 1e-12 of the
/// points' extent. None where the points lie in a line.
std::vector<Vec3> plane_hull(std::vector<Vec3> points);

}  // namespace pantin::detail
