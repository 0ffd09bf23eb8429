#include "engine/solvers/articulated/procedural/push_out.hpp"

#include <algorithm>
#include <limits>

namespace pantin::detail::articulated {
namespace {

/// Whether all half-spaces are satisfied up to rounding.
bool leaves_all(const HalfSpaces& p, Vec3 u) {
  for (std::size_t i = 0; i < p.count; ++i) {
    const Real slack = 1e-10 * (std::abs(p.depths[i]) + glm::length(u));
    if (glm::dot(p.normals[i], u) < p.depths[i] - slack) return false;
  }
  return true;
}

/// The nearest point of the edge of two planes, if they have one.
std::optional<Vec3> edge_of(const HalfSpaces& p, std::size_t i, std::size_t j) {
  const Vec3 n = p.normals[i], m = p.normals[j];
  const Real a = p.depths[i], b = p.depths[j];
  const Real c = glm::dot(n, m), det = 1 - c * c;
  if (!(det > 1e-12)) return std::nullopt;
  return (a - c * b) / det * n + (b - c * a) / det * m;
}

/// The corner of three planes, if they have one.
std::optional<Vec3> corner_of(const HalfSpaces& p, std::size_t i, std::size_t j, std::size_t k) {
  const Vec3 c = glm::cross(p.normals[j], p.normals[k]);
  const Real det = glm::dot(p.normals[i], c);
  if (!(std::abs(det) > 1e-9)) return std::nullopt;
  return (p.depths[i] * c + p.depths[j] * glm::cross(p.normals[k], p.normals[i]) +
          p.depths[k] * glm::cross(p.normals[i], p.normals[j])) /
         det;
}

std::size_t deepest_of(const HalfSpaces& p) {
  const auto first = p.depths.begin();
  const auto end = first + static_cast<std::ptrdiff_t>(p.count);
  return static_cast<std::size_t>(std::max_element(first, end) - first);
}

}  // namespace

void HalfSpaces::add(Vec3 normal, Real depth) {
  for (std::size_t i = 0; i < count; ++i) {
    if (glm::dot(normals[i], normal) < 1 - 1e-12) continue;
    depths[i] = std::max(depths[i], depth);  // the same plane
    return;
  }
  std::size_t at = count;
  if (count == normals.size()) {
    at = static_cast<std::size_t>(std::min_element(depths.begin(), depths.end()) - depths.begin());
    if (depths[at] >= depth) return;
  } else {
    ++count;
  }
  normals[at] = normal, depths[at] = depth;
}

std::optional<Vec3> way_out(const HalfSpaces& p, Real farthest) {
  Vec3 best(0);
  Real least = farthest * farthest;
  bool found = false;
  const auto consider = [&](Vec3 way) {
    const Real d2 = glm::dot(way, way);
    if (d2 < least && leaves_all(p, way)) least = d2, best = way, found = true;
  };
  for (std::size_t i = 0; i < p.count; ++i) consider(p.depths[i] * p.normals[i]);
  if (found) return best;  // no solution is shorter than one along a single normal
  for (std::size_t i = 0; i < p.count; ++i)
    for (std::size_t j = i + 1; j < p.count; ++j)
      if (const std::optional<Vec3> u = edge_of(p, i, j)) consider(*u);
  for (std::size_t i = 0; i < p.count; ++i)
    for (std::size_t j = i + 1; j < p.count; ++j)
      for (std::size_t k = j + 1; k < p.count; ++k)
        if (const std::optional<Vec3> u = corner_of(p, i, j, k)) consider(*u);
  return found ? std::optional(best) : std::nullopt;
}

Vec3 push_out(const HalfSpaces& p) {
  const std::size_t deepest = deepest_of(p);
  return way_out(p, std::numeric_limits<Real>::infinity())
      .value_or(std::max(Real(0), p.depths[deepest]) * p.normals[deepest]);
}

}  // namespace pantin::detail::articulated
