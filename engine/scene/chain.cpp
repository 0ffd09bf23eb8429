#include <cmath>

#include "engine/base/rotation.hpp"
#include "engine/scene/assembly.hpp"

namespace pantin {
namespace {

/// The shortest turn that carries the link's own -y axis to `direction`.
Quat turned_to(Vec3 direction) {
  const Vec3 down(0, -1, 0);
  const Real c = glm::dot(down, direction);
  if (c > 1 - 1e-15) return kNoTurn;
  if (c < -1 + 1e-12) return Quat(0, 0, 0, 1);
  return glm::normalize(Quat(1 + c, glm::cross(down, direction)));
}

/// The half angle between neighbours of `n` equal chords of an arc whose ends are `ratio` times
/// their summed length apart: sin(n a) = ratio n sin(a), on (0, pi/n).
Real half_angle(int n, Real ratio) {
  Real low = 0, high = kPi / n;
  for (int i = 0; i < 200 && low < high; ++i) {
    const Real a = (low + high) / 2;
    if (a == low || a == high) break;
    (std::sin(n * a) > ratio * n * std::sin(a) ? low : high) = a;
  }
  return (low + high) / 2;
}

/// The direction a chain along `along` sags to; some direction across if `sag` points along it.
Vec3 sag_across(Vec3 along, Vec3 sag) {
  for (Vec3 wish : {sag, Vec3(1, 0, 0), Vec3(0, 0, 1)}) {
    const Vec3 across = wish - glm::dot(wish, along) * along;
    if (glm::length(across) > 1e-6) return glm::normalize(across);
  }
  return Vec3(0, 1, 0);
}

/// The corners of a chain: straight on, or on an arc that sags between two points.
std::vector<Vec3> corners(const ChainRecipe& chain) {
  const int n = chain.links;
  Vec3 along = chain.direction;
  Real bend = 0;
  Vec3 side(0);
  if (chain.end) {
    const Vec3 span = *chain.end - chain.start;
    const Real distance = glm::length(span), ratio = distance / (n * chain.length);
    if (distance > 0) along = span / distance;
    side = sag_across(along, chain.sag);
    if (ratio < 1 - 1e-12 && n > 1) bend = half_angle(n, ratio);
  }
  std::vector<Vec3> points{chain.start};
  for (int i = 0; i < n; ++i) {
    const Real angle = bend * (n - 1 - 2 * i);  // of this chord against the straight line
    const Vec3 way = bend == 0 ? along : std::cos(angle) * along + std::sin(angle) * side;
    points.push_back(bend == 0 ? chain.start + (i + 1) * chain.length * along
                               : points.back() + chain.length * way);
  }
  return points;
}

}  // namespace

ChainCourse course_of(const ChainRecipe& chain) {
  ChainCourse course;
  course.joints = corners(chain);
  for (std::size_t i = 0; i + 1 < course.joints.size(); ++i) {
    const Vec3 a = course.joints[i], b = course.joints[i + 1];
    course.links.push_back({0.5 * (a + b), turned_to((b - a) / glm::length(b - a))});
  }
  return course;
}

}  // namespace pantin
