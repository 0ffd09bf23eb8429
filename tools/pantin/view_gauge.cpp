#include "tools/pantin/view_gauge.hpp"

#ifdef PANTIN_HAS_VIEW
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace pantin::program {

using namespace detail;

std::vector<Vec3> Gauge::places(const PosedWorld& scene) const {
  std::vector<Vec3> all;
  for (const Point& p : points_)
    if (const auto at = scene.position_of(p.body, p.anchor)) all.push_back(*at);
  return all;
}

std::string Gauge::words(const PosedWorld& scene) const {
  const std::vector<Vec3> at = places(scene);
  if (at.empty()) return {};
  if (at.size() == 1)
    return fmt::format("from {:.4f}, {:.4f}, {:.4f} m: g at a second point", at[0].x, at[0].y,
                       at[0].z);
  std::string line = fmt::format("distance {:.6g} m", glm::distance(at[0], at[1]));
  if (at.size() < 3) return line + "; g at a third point: an angle";
  const Vec3 a = at[0] - at[1], b = at[2] - at[1];
  const Real angle = std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
  return line + fmt::format(" and {:.6g} m, angle {:.6g} deg", glm::length(b), glm::degrees(angle));
}

}  // namespace pantin::program
#endif
