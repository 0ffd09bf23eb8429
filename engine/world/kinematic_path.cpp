#include "engine/world/kinematic_path.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

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

/// Catmull-Rom for uneven key times: a key is passed with the mean velocity between its neighbours.
Vec3 slope(const Keyframe& before, const Keyframe& after) {
  return (after.pose.position - before.pose.position) / (after.time - before.time);
}

Vec3 slope_at(const Keyframes& path, std::size_t i) {
  const std::vector<Keyframe>& k = path.keys;
  const std::size_t last = k.size() - 1;
  if (i > 0 && i < last) return slope(k[i - 1], k[i + 1]);
  if (!path.loop) return Vec3(0);  // the body comes from rest and goes to rest
  // The neighbour across the seam, one period away; the last key is the first again.
  Keyframe before = k[last - 1];
  before.time -= k[last].time - k[0].time;
  return slope(before, k[1]);
}

Pose along(const Keyframes& path, Real time) {
  const std::vector<Keyframe>& k = path.keys;
  if (k.empty()) return {};
  if (k.size() == 1) return k.front().pose;
  if (path.loop) time = wrapped(time, k.front().time, k.back().time);
  if (!(time > k.front().time)) return k.front().pose;
  if (!(time < k.back().time)) return k.back().pose;
  const auto after = std::upper_bound(k.begin(), k.end(), time,
                                      [](Real t, const Keyframe& key) { return t < key.time; });
  const auto i = static_cast<std::size_t>(after - k.begin()) - 1;
  const Keyframe &a = k[i], &b = k[i + 1];
  const Real span = b.time - a.time, u = (time - a.time) / span, u2 = u * u, u3 = u2 * u;
  const Vec3 position =
      (2 * u3 - 3 * u2 + 1) * a.pose.position + (u3 - 2 * u2 + u) * span * slope_at(path, i) +
      (3 * u2 - 2 * u3) * b.pose.position + (u3 - u2) * span * slope_at(path, i + 1);
  const Quat rotation = b.pose.rotation * glm::conjugate(a.pose.rotation);
  return {position, glm::normalize(fraction_of(rotation, u) * a.pose.rotation)};
}

Vec3 wave(Vec3 amplitude, Vec3 frequency, Vec3 phase, Real time) {
  const auto one = [&](int i) {
    return amplitude[i] == 0 ? 0
                             : amplitude[i] * std::sin(2 * kPi * frequency[i] * time + phase[i]);
  };
  return {one(0), one(1), one(2)};
}

Pose along(const Lissajous& path, Real time) {
  Real fraction = 1;
  if (path.rise > 0 && time < path.rise) {
    const Real u = std::max(time, Real(0)) / path.rise;
    fraction = u * u * u * (10 + u * (6 * u - 15));  // no jump in velocity or acceleration
  }
  const Vec3 shift = fraction * wave(path.amplitude, path.frequency, path.phase, time);
  const Vec3 rotation =
      fraction * wave(path.turn_amplitude, path.turn_frequency, path.turn_phase, time);
  Pose pose{path.centre.position + path.axes * shift, path.centre.rotation};
  if (rotation != Vec3(0))
    pose.rotation =
        glm::normalize(from_rotation_vector(path.axes * rotation) * path.centre.rotation);
  return pose;
}

}  // namespace

Pose pose_at(const KinematicPath& path, Real time) {
  return std::visit([time](const auto& curve) { return along(curve, time); }, path.curve);
}

KinematicPath moved(const KinematicPath& path, const Pose& by) {
  KinematicPath result = path;
  if (auto* keyframes = std::get_if<Keyframes>(&result.curve)) {
    for (Keyframe& key : keyframes->keys) key.pose = compose(by, key.pose);
  } else {
    auto& sway = std::get<Lissajous>(result.curve);
    sway.centre = compose(by, sway.centre);
    sway.axes = glm::normalize(by.rotation * sway.axes);
  }
  return result;
}

KinematicPath shifted(const KinematicPath& path, Real ahead) {
  KinematicPath result = path;
  if (auto* keyframes = std::get_if<Keyframes>(&result.curve)) {
    for (Keyframe& key : keyframes->keys) key.time -= ahead;
  } else {
    auto& sway = std::get<Lissajous>(result.curve);
    sway.phase += 2 * kPi * ahead * sway.frequency;
    sway.turn_phase += 2 * kPi * ahead * sway.turn_frequency;
  }
  return result;
}

}  // namespace pantin
