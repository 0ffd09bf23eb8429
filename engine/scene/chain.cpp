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

/// Where each link points: straight on, or along an arc that sags between two points.
std::vector<Vec3> directions(const ChainRecipe& chain) {
  const int n = chain.links;
  if (!chain.end) return std::vector<Vec3>(static_cast<std::size_t>(n), chain.direction);
  const Vec3 span = *chain.end - chain.start;
  const Real distance = glm::length(span), ratio = distance / (n * chain.length);
  const Vec3 along = distance > 0 ? span / distance : chain.direction;
  const Vec3 side = sag_across(along, chain.sag);
  const Real bend = ratio < 1 - 1e-12 && n > 1 ? half_angle(n, ratio) : 0;
  std::vector<Vec3> ways;
  for (int i = 0; i < n; ++i) {
    const Real angle = bend * (n - 1 - 2 * i);  // of this chord against the straight line
    ways.push_back(std::cos(angle) * along + std::sin(angle) * side);
  }
  return ways;
}

}  // namespace

ChainCourse course_of(const ChainRecipe& chain) {
  ChainCourse course;
  course.joints.push_back(chain.start);
  Vec3 way(0);  // summed up apart from the start, which may be large
  for (const Vec3 direction : directions(chain)) {
    const Vec3 before = chain.start + chain.length * way;
    way += direction;
    course.joints.push_back(chain.start + chain.length * way);
    course.links.push_back({0.5 * (before + course.joints.back()), turned_to(direction)});
  }
  return course;
}

}  // namespace pantin
