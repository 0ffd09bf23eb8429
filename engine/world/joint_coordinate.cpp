#include "engine/world/joint_coordinate.hpp"

#include "engine/joints/kinds.hpp"

namespace pantin::detail {

BodyState state_of(const Body& b) {
  return {b.pose.position, b.pose.rotation, glm::mat3_cast(b.pose.rotation), b.velocity,
          b.angular_velocity};
}

CoordinateAt coordinate_at(const World& world, const Link& link, Coordinate which, Real before) {
  const BodyState a = state_of(world.bodies[link.a]), b = state_of(world.bodies[link.b]);
  CoordinateAt at;
  Vec3 j[4];
  write_coordinate({link.joint, a, b, before}, which, {&at.value, j, nullptr});
  at.rate = glm::dot(j[0], a.velocity) + glm::dot(j[1], a.angular_velocity) +
            glm::dot(j[2], b.velocity) + glm::dot(j[3], b.angular_velocity);
  return at;
}

}  // namespace pantin::detail
