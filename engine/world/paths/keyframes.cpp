#include "engine/world/paths/keyframes.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/rotation.hpp"

namespace pantin {

using namespace detail;

namespace {

/// `time` wrapped into the period of a path from `first` to `last`.
Real wrapped(Real time, Real first, Real last) {
  const Real period = last - first;
  const Real into = std::fmod(time - first, period);
  return first + (into < 0 ? into + period : into);
}

/// Catmull-Rom for uneven key times: the slope at a key is the mean velocity between its
/// neighbours.
Vec3 slope(const Keyframe& before, const Keyframe& after) {
  return (after.pose.position - before.pose.position) / (after.time - before.time);
}

Vec3 slope_at(const Keyframes& path, std::size_t i) {
  const std::vector<Keyframe>& k = path.keys;
  const std::size_t last = k.size() - 1;
  if (i > 0 && i < last) return slope(k[i - 1], k[i + 1]);
  if (!path.loop) return Vec3(0);  // the path starts and ends at rest
  // The neighbour across the seam, one period away; the last key is the first again.
  Keyframe before = k[last - 1];
  before.time -= k[last].time - k[0].time;
  return slope(before, k[1]);
}

}  // namespace

Pose Keyframes::at(Real time) const {
  const std::vector<Keyframe>& k = keys;
  if (k.empty()) return {};
  if (k.size() == 1) return k.front().pose;
  if (loop) time = wrapped(time, k.front().time, k.back().time);
  if (!(time > k.front().time)) return k.front().pose;
  if (!(time < k.back().time)) return k.back().pose;
  const auto after = std::upper_bound(k.begin(), k.end(), time,
                                      [](Real t, const Keyframe& key) { return t < key.time; });
  const auto i = static_cast<std::size_t>(after - k.begin()) - 1;
  const Keyframe &a = k[i], &b = k[i + 1];
  const Real span = b.time - a.time, u = (time - a.time) / span, u2 = u * u, u3 = u2 * u;
  const Vec3 position =
      (2 * u3 - 3 * u2 + 1) * a.pose.position + (u3 - 2 * u2 + u) * span * slope_at(*this, i) +
      (3 * u2 - 2 * u3) * b.pose.position + (u3 - u2) * span * slope_at(*this, i + 1);
  const Quat rotation = b.pose.rotation * glm::conjugate(a.pose.rotation);
  return {position, glm::normalize(fraction_of(rotation, u) * a.pose.rotation)};
}

void Keyframes::move(const Pose& by) {
  for (Keyframe& key : keys) key.pose = compose(by, key.pose);
}

void Keyframes::shift(Real ahead) {
  for (Keyframe& key : keys) key.time -= ahead;
}

void Keyframes::start_from(const Pose& start) {
  for (Keyframe& key : keys) {
    if (!is_finite(key.pose.position)) key.pose.position = start.position;
    if (!is_finite(key.pose.rotation)) key.pose.rotation = start.rotation;
  }
}

Pose Keyframes::seam() const {
  if (!loop || keys.empty()) return {};
  const Pose &first = keys.front().pose, &last = keys.back().pose;
  return {last.position - first.position, last.rotation * glm::conjugate(first.rotation)};
}

PathBounds Keyframes::bounds() const {
  PathBounds all;
  for (const Keyframe& key : keys) all.add(key.pose.position);
  return all;
}

}  // namespace pantin
