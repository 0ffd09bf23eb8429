#include "engine/world/paths/steady.hpp"

#include "engine/base/rotation.hpp"

namespace pantin {

using namespace detail;

Quat SteadyMotion::turn(Real time) const {
  return axes * from_rotation_vector(time * angular_velocity) * glm::conjugate(axes);
}

Pose SteadyMotion::at(Real time) const {
  const Vec3 away = time * velocity + from_rotation_vector(time * angular_velocity) * arm;
  return {centre.position + axes * away, glm::normalize(turn(time) * centre.rotation)};
}

void SteadyMotion::move(const Pose& by) {
  centre = compose(by, centre);
  axes = glm::normalize(by.rotation * axes);
}

void SteadyMotion::shift(Real ahead) {
  centre.position += axes * (ahead * velocity);
  centre.rotation = glm::normalize(turn(ahead) * centre.rotation);
  arm = from_rotation_vector(ahead * angular_velocity) * arm;
}

void SteadyMotion::start_from(const Pose& start) {
  centre.rotation = start.rotation;
  if (!is_finite(centre.position)) centre.position = start.position;
  if (!is_finite(arm)) arm = glm::conjugate(axes) * (start.position - centre.position);
}

PathBounds SteadyMotion::bounds() const {
  // A translation has no bounds: ten seconds of it.
  constexpr Real kSeconds = 10;
  PathBounds all;
  const Vec3 reach(glm::length(arm));
  for (const Real time : {0.0, kSeconds}) {
    const Vec3 middle = centre.position + axes * (time * velocity);
    all.add(middle + reach), all.add(middle - reach);
  }
  return all;
}

}  // namespace pantin
