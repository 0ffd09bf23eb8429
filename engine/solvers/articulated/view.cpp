// An island as the kernels see it, and points of bodies.
#include <cstddef>

#include "engine/contact/detect.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

constexpr std::size_t words(std::size_t bytes) { return bytes / sizeof(Real); }

static_assert(sizeof(Body) % sizeof(Real) == 0);

static_assert(offsetof(Quat, x) == 0 && offsetof(Quat, w) == 3 * sizeof(Real));

const BodyLayout kLayout{words(sizeof(Body)), words(offsetof(Body, pose.position)),
                         words(offsetof(Body, pose.rotation)), words(offsetof(Body, velocity)),
                         words(offsetof(Body, angular_velocity))};

}  // namespace

IslandView view_of(World& world, Island& a) {
  PANTIN_ASSERT(a.scratch.nodes.size() == kNodeSize * a.count() &&
                a.parents.size() == a.slots.size());
  PANTIN_ASSERT(!a.forced || !a.scratch.forces.numbers().empty());
  return {a.count(),
          a.slots.data(),
          a.parents.data(),
          reinterpret_cast<Real*>(world.bodies.values().data()),
          kLayout,
          a.constants.data(),
          a.memory.data(),
          a.scratch.work.data(),
          a.scratch.nodes.data(),
          a.forced ? a.scratch.forces.data() : nullptr,
          a.children.data(),
          a.is_chain};
}

Vec3 point_at(const Island& a, std::size_t column, Vec3 anchor, PoseRows at) {
  return a.scratch.work.vec(at.position, column) +
         a.scratch.work.quat(at.rotation, column) * anchor;
}

Vec3 point_on(const World& world, std::uint32_t slot, Vec3 anchor) {
  PANTIN_ASSERT(slot < world.bodies.size());
  return to_world(world.bodies.values()[slot].pose, anchor);
}

Pose pose_before(const World& world, std::uint32_t slot, Real h) {
  const Body& b = world.bodies.values()[slot];
  return b.teleport ? b.pose : contact::pose_before(b, h);
}
Vec3 point_before(const World& world, std::uint32_t slot, Vec3 anchor, Real h) {
  return to_world(pose_before(world, slot, h), anchor);
}

}  // namespace pantin::detail::articulated
