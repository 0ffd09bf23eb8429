#pragma once
// Distances and angles between points of bodies.
#include <string>
#include <vector>

#include "engine/render/bounds.hpp"

namespace pantin::program {

using namespace detail;

/// Up to three points that stay on their bodies: the distance of the first two, and with a third
/// the angle at the second.
class Gauge {
 public:
  struct Point {
    Entity body;
    Vec3 anchor;  // in the body's mass-centre frame, m
  };

  /// Adds a point; after three it starts anew.
  void add(const Point& point) {
    if (points_.size() == 3) points_.clear();
    points_.push_back(point);
  }
  void clear() { points_.clear(); }
  bool empty() const { return points_.empty(); }

  /// The present places of the points, world, m; none of bodies that are gone.
  std::vector<Vec3> places(const PosedWorld& scene) const;
  /// The result as a line of text; empty without points.
  std::string words(const PosedWorld& scene) const;

 private:
  std::vector<Point> points_;
};

}  // namespace pantin::program
