#include <cmath>
#include <numeric>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/scene/build/build.hpp"

namespace pantin::detail {
namespace {

/// The shortest rotation from the link's own -y axis to `direction`.
Quat turned_to(Vec3 direction) {
  const Vec3 down(0, -1, 0);
  const Real c = glm::dot(down, direction);
  if (c > 1 - 1e-15) return kIdentity;
  if (c < -1 + 1e-12) return Quat(0, 0, 0, 1);
  return glm::normalize(Quat(1 + c, glm::cross(down, direction)));
}

/// The rotation from -y to `direction` with z as close to `axis` as possible.
Quat turned_to(Vec3 direction, Vec3 axis) {
  const Vec3 z = axis - glm::dot(axis, direction) * direction;
  if (glm::length(z) < 1e-9) return turned_to(direction);
  const Vec3 out = glm::normalize(z);
  return glm::normalize(glm::quat_cast(Mat3(glm::cross(-direction, out), -direction, out)));
}

/// Half the angle between consecutive chords of an arc of `n` equal chords, where `ratio` is the
/// distance of its ends over the sum of the chords: sin(n a) = ratio n sin(a), on (0, pi/n).
Real half_angle(int n, Real ratio) {
  Real low = 0, high = kPi / n;
  for (int i = 0; i < 200 && low < high; ++i) {
    const Real a = (low + high) / 2;
    if (a == low || a == high) break;
    (std::sin(n * a) > ratio * n * std::sin(a) ? low : high) = a;
  }
  return (low + high) / 2;
}

/// The direction of sag across `along`; any perpendicular direction if `sag` is parallel to it.
Vec3 sag_across(Vec3 along, Vec3 sag) {
  for (Vec3 wish : {sag, Vec3(1, 0, 0), Vec3(0, 0, 1)}) {
    const Vec3 across = wish - glm::dot(wish, along) * along;
    if (glm::length(across) > 1e-6) return glm::normalize(across);
  }
  return Vec3(0, 1, 0);
}

/// Equal links along an arc that sags between two points.
std::vector<Vec3> arc_of(const ChainRecipe& chain) {
  const int n = chain.links;
  const Vec3 span = *chain.end - chain.start;
  const Real distance = glm::length(span), ratio = distance / (n * chain.length);
  const Vec3 along = distance > 0 ? span / distance : chain.direction;
  const Vec3 side = sag_across(along, chain.sag);
  const Real bend = ratio < 1 - 1e-12 && n > 1 ? half_angle(n, ratio) : 0;
  std::vector<Vec3> ways;
  for (int i = 0; i < n; ++i) {
    const Real angle = bend * (n - 1 - 2 * i);  // of this chord to the straight line
    ways.push_back(std::cos(angle) * along + std::sin(angle) * side);
  }
  return ways;
}

/// Equal links around a circle: the first along the chain's direction, the next towards its sag.
std::vector<Vec3> ring_of(const ChainRecipe& chain) {
  const Vec3 side = sag_across(chain.direction, chain.sag);
  std::vector<Vec3> ways;
  for (int i = 0; i < chain.links; ++i) {
    const Real angle = 2 * kPi * i / chain.links;
    ways.push_back(std::cos(angle) * chain.direction + std::sin(angle) * side);
  }
  return ways;
}

/// The direction of each link.
std::vector<Vec3> directions(const ChainRecipe& chain) {
  if (chain.end) return arc_of(chain);
  if (chain.closed) return ring_of(chain);
  return std::vector<Vec3>(static_cast<std::size_t>(chain.links), chain.direction);
}

ChainLayout equal_links(const ChainRecipe& chain) {
  ChainLayout layout;
  layout.joints.push_back(chain.start);
  Vec3 way(0);  // summed separately from the start, whose large coordinates would lose digits
  for (const Vec3 direction : directions(chain)) {
    const Vec3 before = chain.start + chain.length * way;
    way += direction;
    layout.joints.push_back(chain.start + chain.length * way);
    layout.links.push_back({0.5 * (before + layout.joints.back()), turned_to(direction)});
    layout.lengths.push_back(chain.length);
  }
  return layout;
}

ChainLayout along_path(const ChainRecipe& chain) {
  ChainLayout layout;
  layout.joints = chain.path;
  if (chain.closed) layout.joints.push_back(chain.path.front());
  for (std::size_t i = 0; i + 1 < layout.joints.size(); ++i) {
    const Vec3 from = layout.joints[i], to = layout.joints[i + 1];
    layout.lengths.push_back(glm::length(to - from));
    layout.links.push_back({0.5 * (from + to), turned_to((to - from) / layout.lengths.back())});
  }
  return layout;
}

/// The axis about which the chain bends most, or none if it is straight.
std::optional<Vec3> bend_axis(const ChainLayout& layout) {
  Vec3 sum(0), size(0);
  for (std::size_t i = 0; i + 2 < layout.joints.size(); ++i) {
    const Vec3 a = layout.joints[i + 1] - layout.joints[i],
               b = layout.joints[i + 2] - layout.joints[i + 1];
    sum += glm::cross(a, b), size.x += glm::dot(a, a);
  }
  if (glm::length(sum) < 1e-9 * size.x) return std::nullopt;
  return glm::normalize(sum);
}

}  // namespace

Vec3 ChainLayout::middle() const {
  if (!is_closed) return 0.5 * (joints.front() + joints.back());
  Vec3 sum(0);
  for (const Pose& link : links) sum += link.position;
  return sum / static_cast<Real>(links.size());
}

ChainLayout layout_of(const ChainRecipe& chain) {
  ChainLayout layout = chain.path.empty() ? equal_links(chain) : along_path(chain);
  layout.is_closed = chain.closed;
  std::optional<Vec3> axis = chain.axis;
  const bool bends = info_of(chain.turn.kind).uses_axes || chain.closed || !chain.path.empty();
  if (!axis && bends) axis = bend_axis(layout);
  if (!axis) return layout;
  for (std::size_t i = 0; i < layout.links.size(); ++i)
    layout.links[i].rotation =
        turned_to(glm::normalize(layout.joints[i + 1] - layout.joints[i]), *axis);
  return layout;
}

Quat chain_axes(JointKind kind) {
  const Vec3 along(0, -1, 0), out(0, 0, 1);
  const bool bends = turns_of(kind) == Turns::about_x;
  const Mat3 axes =
      bends ? Mat3(out, along, glm::cross(out, along)) : Mat3(along, out, glm::cross(along, out));
  return glm::normalize(glm::quat_cast(axes));
}

}  // namespace pantin::detail
