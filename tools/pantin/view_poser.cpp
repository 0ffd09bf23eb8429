#include "tools/pantin/view_poser.hpp"

#ifdef PANTIN_HAS_VIEW
#include "engine/world/cable_route.hpp"
#include "engine/world/surface_start.hpp"

namespace pantin::program {

using namespace detail;

namespace {

constexpr Real kStretched = 0.01;  // of the length of a cable
constexpr int kIterations = 12;    // in one picture
/// Weight of a rotation that is kept, per m^2: it comes before the place.
constexpr Real kKeptRotation = 1e6;

/// Without memory of solvers: revolutions are counted anew, from the present poses.
World without_memory(const World& world) {
  World copy = world;
  copy.memory = {};
  return copy;
}

/// Elastic cables that are hardly stretched, such as the strings of a puppet.
std::vector<Entity> stiff_cables(const World& world) {
  std::vector<Entity> stiff;
  const auto pose_of = [&](Entity body) -> const Pose* {
    const Body* found = world.bodies.find(body);
    return found ? &found->pose : nullptr;
  };
  for (std::size_t i = 0; i < world.cables.size(); ++i) {
    const Cable& cable = world.cables.values()[i];
    if (cable.joint.compliance > 0 && stretch_of(cable, pose_of) < kStretched * cable.joint.length)
      stiff.push_back(world.cables.owners()[i]);
  }
  return stiff;
}

/// The laws of a World; elastic cables of a list count as inextensible.
World model_of(const World& world, const std::vector<Entity>& stiff) {
  World copy = without_memory(world);
  for (const Entity e : stiff)
    if (Cable* cable = copy.cables.find(e)) cable->joint.compliance = 0;
  return copy;
}

Pose origin_of(const World& world, Entity body) {
  const Pose* origin = world.origins.find(body);
  return origin ? *origin : Pose{};
}

bool moves_in_plane(const SolverSettings& settings) {
  return settings.solver == Solver::planar || settings.solver == Solver::quasistatic;
}

}  // namespace

std::string pose_fault(const World& world) {
  bool in_plane = moves_in_plane(world.default_settings);
  for (const SolverSettings& s : world.settings.values()) in_plane = in_plane || moves_in_plane(s);
  return in_plane
             ? "pose mode is for mechanisms in space, not for the solvers planar and quasistatic"
             : std::string();
}

Poser::Poser(const World& world)
    : stiff_(stiff_cables(world)), assembler_(model_of(world, stiff_)) {}

void Poser::renew(const World& world) {
  assembler_ = Assembler(model_of(world, stiff_));
  holds_ = holds_ && world.bodies.find(point_.body);
  if (holds_) add_target(world);
}

void Poser::take(const World& world, const PosedPoint& point) {
  let_go();
  point_ = point, holds_ = true;
  offset_ = world.origin_pose(point.body).position -
            to_world(world.bodies[point.body].pose, point.anchor);
  add_target(world);
}

Vec3 Poser::target_of_frame() const {
  return point_.grip == PoseGrip::point ? point_.target : point_.target + offset_;
}

void Poser::add_target(const World& world) {
  const Entity body = point_.body;
  if (point_.grip == PoseGrip::point) {
    const auto added =
        assembler_.add(PointTarget{.body = body,
                                   .point = to_local(origin_of(world, body), point_.anchor),
                                   .target = point_.target});
    holds_ = static_cast<bool>(added);
    if (added) target_ = *added;
    return;
  }
  const auto added =
      assembler_.add(PoseTarget{.body = body,
                                .target = {target_of_frame(), world.origin_pose(body).rotation},
                                .turn_weight = kKeptRotation});
  holds_ = static_cast<bool>(added);
  if (added) target_ = *added;
}

void Poser::move(Vec3 target) {
  point_.target = target;
  if (holds_) assembler_.move(target_, target_of_frame());
}

void Poser::let_go() {
  if (holds_) assembler_.remove(target_);
  holds_ = false;
}

void Poser::follow(World& world) {
  if (!holds_ && !has_moved_) return;
  joint_error_ = assembler_.settle(kIterations).joints;
  assembler_.write_to(world);
  has_moved_ = true;
}

World at_rest(const World& world) {
  World still = without_memory(world);
  for (Body& b : still.bodies.values())
    if (b.motion == Motion::dynamic) {
      b.velocity = b.angular_velocity = Vec3(0);
      b.restart = b.teleport = true;
    }
  for (SurfaceContact& c : still.surface_contacts.values()) {
    if (c.over) continue;
    const auto pose = [&](Entity e) {
      const Body* body = still.bodies.find(e);
      return body ? body->pose : Pose{};
    };
    c.known = false;
    place_surfaces(c, {pose(c.a), pose(c.b)});
  }
  still.mark_dirty();
  return still;
}

}  // namespace pantin::program
#endif
