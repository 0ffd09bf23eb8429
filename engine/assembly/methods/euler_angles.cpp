// Gradient descent in Euler angles: rotations z, then y, then x in the turned axes.
//
//   w = B (z', y', x')     B: axes of the three rotations, world
//
// B is singular where y is a quarter turn; there the gradient misses a direction.
#include <algorithm>
#include <cmath>

#include "engine/assembly/methods/comparison.hpp"
#include "engine/base/rotation.hpp"

namespace pantin::detail::assembly {
namespace {

constexpr Real kGain = 0.1;

struct Angles {
  Real z = 0, y = 0, x = 0;
};

Angles angles_of(Quat q) {
  const Mat3 r = glm::mat3_cast(q);
  return {std::atan2(r[0].y, r[0].x), std::asin(std::clamp(-r[0].z, Real(-1), Real(1))),
          std::atan2(r[1].z, r[2].z)};
}

Quat about(int axis, Real angle) {
  Vec3 v(0);
  v[axis] = angle;
  return from_rotation_vector(v);
}

}  // namespace

Ending descend_euler_angles(Descent& d) {
  lagrangian::Motions& s = d.part.m.scratch.state;
  std::vector<Angles> angles;
  for (const Quat& q : s.q) angles.push_back(angles_of(q));
  return iterate(d, [&] {
    find_gradient(d);
    for (std::size_t b = 0; b < d.part.m.count(); ++b) {
      const Vec3 torque = d.part.m.scratch.force[2 * b + 1];
      Angles& a = angles[b];
      const Quat z = about(2, a.z), zy = z * about(1, a.y);
      const Real by_z = torque.z, by_y = glm::dot(z * Vec3(0, 1, 0), torque),
                 by_x = glm::dot(zy * Vec3(1, 0, 0), torque);
      a.z -= kGain * by_z, a.y -= kGain * by_y, a.x -= kGain * by_x;
      s.x[b] -= kGain * d.part.m.scratch.force[2 * b];
      s.q[b] = glm::normalize(about(2, a.z) * about(1, a.y) * about(0, a.x));
    }
    look(d.world, d.part), count(d.world, d.part);
  });
}

}  // namespace pantin::detail::assembly
