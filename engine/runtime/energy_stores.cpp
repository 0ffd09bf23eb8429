#include "engine/runtime/energy_stores.hpp"

#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/joints/joint_force.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/joints/stops.hpp"
#include "engine/world/cable_route.hpp"
#include "engine/world/joint_coordinate.hpp"

namespace pantin::detail {
namespace {

/// The energy of a spring whose force is `stiffness * off`, at most `cap`.
Real energy_of(Real stiffness, Real off, Real cap) {
  off = std::abs(off);
  if (stiffness * off <= cap) return 0.5 * stiffness * off * off;
  return cap * (off - 0.5 * cap / stiffness);
}

const Dof& dof_of(const Link& link, Coordinate along) {
  const JointParameters& own = *link.joint.parameters;
  return along == Coordinate::angle ? own.rotation : own.translation;
}

void find_coordinate(const World& world, EnergyStore& s) {
  const Link& link = world.links.values()[s.slot];
  const CoordinateAt now = coordinate_at(world, link, s.along, s.x);
  s.x = now.value, s.rate = now.rate;
}

Real energy_of(const Dof& dof, Real x) {
  Real sum = detail::energy_of(dof.spring, x);
  if (dof.motor.kind == MotorKind::position)
    sum += energy_of(dof.motor.gain, x - dof.motor.target, dof.motor.cap);
  return sum;
}

/// The greatest power of a velocity motor at rates between `low` and `high`, W.
Real most_power(const JointMotor& motor, Real low, Real high) {
  if (low > high) std::swap(low, high);
  const auto power = [&](Real rate) {
    return std::clamp(motor.gain * (motor.target - rate), -motor.cap, motor.cap) * rate;
  };
  // Without the cap the power is a parabola with its peak at half the target. With it, the power
  // grows up to where the cap ends.
  const Real slack = motor.gain > 0 ? motor.cap / motor.gain : 0;
  Real most = std::max(power(low), power(high));
  for (const Real at : {motor.target / 2, motor.target - slack, motor.target + slack})
    most = std::max(most, power(std::clamp(at, low, high)));
  return most;
}

/// The angle from the drive's target to the present rotation of the joint, rad.
Real off_target(Quat turn, Quat target) {
  return glm::length(rotation_vector(glm::conjugate(target) * turn));
}

Quat turn_of(const World& world, const Link& link) {
  return relative_rotation(link.joint, world.bodies[link.a].pose.rotation,
                           world.bodies[link.b].pose.rotation);
}

Real energy_of(const JointDrive& drive, Quat turn, Quat target) {
  return energy_of(drive.stiffness, off_target(turn, target), drive.max_torque);
}

Real energy_of_soft_stops(const World& world, const Link& link) {
  const BodyState a = state_of(world.bodies[link.a]), b = state_of(world.bodies[link.b]);
  return soft_stop_energy({link.joint, a, b});
}

Real energy_of(const World& world, const Cable& c) {
  const auto pose_of = [&](Entity e) { return &world.bodies[e].pose; };
  return energy_of(c.joint, stretch_of(c, pose_of));
}

/// The vector from the point to `target`.
Vec3 gap_of(const World& world, const Pin& p, Vec3 target) {
  const Vec3 to = p.to ? to_world(world.bodies[p.to].pose, target) : target;
  return to - to_world(world.bodies[p.body].pose, p.anchor);
}

/// The energy at the previous target, so that a moving target does work.
void begin_pin(const World& world, EnergyStore& s) {
  const Pin& p = world.pins.values()[s.slot];
  s.gap = gap_of(world, p, s.place);
  s.energy = 0.5 * p.stiffness * glm::dot(s.gap, s.gap);
}

/// An upper bound on the work of a moving target: by the force at the start or at the end, plus the
/// force that the damper transmits.
Real work_of_target(const World& world, const EnergyStore& before, const EnergyStore& now, Real h) {
  const Pin& p = world.pins.values()[now.slot];
  const Vec3 way = now.place - before.place;
  if (p.to || way == Vec3(0)) return 0;
  return p.stiffness * std::max(glm::dot(before.gap, way), glm::dot(now.gap, way)) +
         p.damping / 4 * glm::dot(way, way) / h;
}

/// The slot of a dynamic body among these, or kNoSlot; kNoSlot also if one is gone.
std::uint32_t dynamic_of(const World& world, std::initializer_list<Entity> bodies) {
  std::uint32_t found = kNoSlot;
  for (const Entity e : bodies) {
    const std::uint32_t slot = world.bodies.slot(e);
    if (slot == kNoSlot) return kNoSlot;
    if (world.bodies.values()[slot].motion == Motion::dynamic) found = slot;
  }
  return found;
}

std::uint32_t dynamic_of(const World& world, const Cable& c) {
  std::uint32_t found = dynamic_of(world, {c.a, c.b});
  const bool there = world.bodies.find(c.a) && world.bodies.find(c.b);
  for (const CableGuide& g : c.guides) {
    if (!there || !world.bodies.find(g.body)) return kNoSlot;
    found = std::min(found, dynamic_of(world, {g.body}));
  }
  return found;
}

std::uint32_t dynamic_of(const World& world, const Pin& p) {
  return p.to ? dynamic_of(world, {p.body, p.to}) : dynamic_of(world, {p.body});
}

void list_joint(const World& world, std::uint32_t slot, std::vector<EnergyStore>& stores) {
  const Link& link = world.links.values()[slot];
  EnergyStore s;
  s.slot = slot, s.body = dynamic_of(world, {link.a, link.b});
  if (s.body == kNoSlot) return;
  const JointKindInfo& info = info_of(link.joint.kind);
  for (const Coordinate along : {Coordinate::angle, Coordinate::travel}) {
    if (!info.find(along) || !dof_of(link, along).any()) continue;
    s.along = along;
    find_coordinate(world, s);
    stores.push_back(s);
  }
  if (link.joint.limits.any() && link.joint.limits->soft_zone > 0) {
    s.kind = EnergyStore::Kind::soft_stop;
    stores.push_back(s);
  }
  const std::uint32_t drive = world.joint_drives.slot(world.links.owners()[slot]);
  if (drive == kNoSlot || world.joint_drives.values()[drive].exact) return;
  s.kind = EnergyStore::Kind::drive, s.slot = drive;
  stores.push_back(s);
}

}  // namespace

void list_stores(const World& world, std::vector<EnergyStore>& stores) {
  stores.clear();
  for (std::uint32_t i = 0; i < world.links.size(); ++i) list_joint(world, i, stores);
  for (std::uint32_t i = 0; i < world.cables.size(); ++i) {
    const Cable& c = world.cables.values()[i];
    EnergyStore s;
    s.kind = EnergyStore::Kind::cable, s.slot = i, s.body = dynamic_of(world, c);
    if (c.joint.compliance > 0 && s.body != kNoSlot) stores.push_back(s);
  }
  for (std::uint32_t i = 0; i < world.pins.size(); ++i) {
    const Pin& p = world.pins.values()[i];
    EnergyStore s;
    s.kind = EnergyStore::Kind::pin, s.slot = i, s.body = dynamic_of(world, p);
    s.place = p.target;
    if (p.kind == PinKind::spring && s.body != kNoSlot) stores.push_back(s);
  }
}

void begin_store(const World& world, EnergyStore& s) {
  switch (s.kind) {
    case EnergyStore::Kind::coordinate:
      find_coordinate(world, s);
      s.energy = energy_of(dof_of(world.links.values()[s.slot], s.along), s.x);
      return;
    case EnergyStore::Kind::drive: {
      const JointDrive& drive = world.joint_drives.values()[s.slot];
      s.turn = turn_of(world, world.links[world.joint_drives.owners()[s.slot]]);
      s.target = target_at(drive, world.time);
      s.energy = energy_of(drive, s.turn, s.target);
      return;
    }
    case EnergyStore::Kind::soft_stop:
      s.energy = energy_of_soft_stops(world, world.links.values()[s.slot]);
      return;
    case EnergyStore::Kind::cable:
      s.energy = energy_of(world, world.cables.values()[s.slot]);
      return;
    case EnergyStore::Kind::pin:
      begin_pin(world, s);
      return;
  }
}

StoreChange end_store(const World& world, EnergyStore& s, Real h) {
  const EnergyStore before = s;
  if (s.kind == EnergyStore::Kind::pin) s.place = world.pins.values()[s.slot].target;
  begin_store(world, s);
  StoreChange change;
  if (s.kind == EnergyStore::Kind::coordinate) {
    s.moved = s.x - before.x;
    const JointMotor& motor = dof_of(world.links.values()[s.slot], s.along).motor;
    if (motor.kind == MotorKind::velocity) {
      const Real mean = (s.x - before.x) / h;
      const auto [low, high] = std::minmax({before.rate, s.rate, mean});
      change.worked = h * most_power(motor, low, high);
    }
  } else if (s.kind == EnergyStore::Kind::drive) {
    // A moving target does work on the joint: by the torque at the start or at the end.
    const JointDrive& drive = world.joint_drives.values()[s.slot];
    s.target = target_at(drive, world.time + h);
    s.energy = energy_of(drive, s.turn, s.target);
    const Real speed = glm::length(rotation_vector(s.target * glm::conjugate(before.target))) / h;
    change.worked = std::max(energy_of(drive, before.turn, s.target) - before.energy,
                             s.energy - energy_of(drive, s.turn, before.target)) +
                    h * std::min(drive.damping * speed / 4, drive.max_torque) * speed;
  }
  if (s.kind == EnergyStore::Kind::pin) change.worked = work_of_target(world, before, s, h);
  change.stored = s.energy - before.energy;
  return change;
}

}  // namespace pantin::detail
