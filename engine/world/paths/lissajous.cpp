#include "engine/world/paths/lissajous.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/rotation.hpp"

namespace pantin {

using namespace detail;

namespace {

Vec3 wave(Vec3 amplitude, Vec3 frequency, Vec3 phase, Real time) {
  const auto one = [&](int i) {
    return amplitude[i] == 0 ? 0
                             : amplitude[i] * std::sin(2 * kPi * frequency[i] * time + phase[i]);
  };
  return {one(0), one(1), one(2)};
}

}  // namespace

Pose Lissajous::at(Real time) const {
  Real fraction = 1;
  if (rise > 0 && time < rise) {
    const Real u = std::max(time, Real(0)) / rise;
    fraction = u * u * u * (10 + u * (6 * u - 15));  // no jump in velocity or acceleration
  }
  const Vec3 aside = fraction * wave(amplitude, frequency, phase, time);
  const Vec3 rotation = fraction * wave(turn_amplitude, turn_frequency, turn_phase, time);
  Pose pose{centre.position + axes * aside, centre.rotation};
  if (rotation != Vec3(0))
    pose.rotation = glm::normalize(from_rotation_vector(axes * rotation) * centre.rotation);
  return pose;
}

void Lissajous::move(const Pose& by) {
  centre = compose(by, centre);
  axes = glm::normalize(by.rotation * axes);
}

void Lissajous::shift(Real ahead) {
  phase += 2 * kPi * ahead * frequency;
  turn_phase += 2 * kPi * ahead * turn_frequency;
}

void Lissajous::start_from(const Pose& start) {
  const Vec3 given = centre.position;
  centre = {};
  const Pose away = at(0);  // displacement from the centre
  centre.position = is_finite(given) ? given : start.position - away.position;
  centre.rotation = glm::conjugate(away.rotation) * start.rotation;
}

PathBounds Lissajous::bounds() const {
  PathBounds all;
  const Mat3 along = glm::mat3_cast(axes);
  Vec3 reach(0);
  for (int i = 0; i < 3; ++i) reach += glm::abs(along[i] * amplitude[i]);
  all.add(centre.position + reach), all.add(centre.position - reach);
  return all;
}

}  // namespace pantin
