// The planar solver's row in the table of solvers.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "engine/base/invariants.hpp"
#include "engine/base/rotation.hpp"
#include "engine/contact/detect.hpp"
#include "engine/contact/memory.hpp"
#include "engine/joints/joint_force.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/solvers/planar/island.hpp"
#include "engine/solvers/solver.hpp"
#include "engine/world/joint_coordinate.hpp"

namespace pantin::detail::planar {
namespace {

constexpr Real kTimeToSleep = 0.5;  // s
constexpr Real kPinMoved = 1e-9;    // m
constexpr Real kDriveMoved = 1e-9;  // rad, m
constexpr Real kWidest = 1e12;      // m, m/s: larger motions are failures

/// Largest distance of a body's points from its mass centre, m.
Real extent_of(const World& world, const FlatBody& f) {
  const Shapes* shapes = world.shapes.find(f.body);
  const Body& b = world.bodies.values()[f.slot];
  const Real inertia = glm::max(b.inertia.x, glm::max(b.inertia.y, b.inertia.z));
  return std::max(shapes ? contact::extent_of(*shapes) : 0, std::sqrt(inertia / b.mass));
}

/// Whether a body was changed: moved by the caller, pushed, or moving on its path.
bool was_changed(const World& world, const FlatBody& f) {
  const Body& b = world.bodies.values()[f.slot];
  if (b.restart || b.teleport) return true;
  if (f.island == kNobody) return contact::moves(b);
  const Force* push = world.forces.find(f.body);
  return push && (push->force != Vec3(0) || push->torque != Vec3(0));
}

/// Distance of a pin from its target in the plane, m.
Real gap_of(const World& world, const Planar& all, const FlatPin& p) {
  const Pin& pin = world.pins.values()[p.pin];
  const auto pose_of = [&](std::uint32_t body) {
    return world.bodies.values()[all.bodies[body].slot].pose;
  };
  const Vec3 to = p.to == kNobody ? pin.target : to_world(pose_of(p.to), pin.target);
  return glm::length((to - to_world(pose_of(p.body), pin.anchor)) * Vec3(1, 1, 0));
}

/// Whether the plane is asleep: quiet for long enough, and unchanged.
bool rests(const World& world, const Planar& all, Real h) {
  if (!(all.sleep_speed > 0) || all.still * h < kTimeToSleep) return false;
  if (world.gravity != all.gravity) return false;
  for (const FlatDrive& d : all.drives) {
    const JointDrive& drive = world.joint_drives.values()[d.drive];
    const Real next = motion_at(drive.motion, world.time + h).value;
    if (!(std::abs(next - d.value) <= kDriveMoved)) return false;
  }
  for (const FlatPin& p : all.pins)
    if (gap_of(world, all, p) > kPinMoved) return false;
  return std::none_of(all.bodies.begin(), all.bodies.end(),
                      [&](const FlatBody& f) { return was_changed(world, f); });
}

void note_stillness(const World& world, Planar& all) {
  Real fastest = 0;
  for (const FlatBody& f : all.bodies) {
    if (f.island == kNobody) continue;
    const Body& b = world.bodies.values()[f.slot];
    fastest = std::max(
        fastest, glm::length(b.velocity) + extent_of(world, f) * std::abs(b.angular_velocity.z));
  }
  all.still = fastest < all.sleep_speed ? all.still + 1 : 0;
  all.gravity = world.gravity;
}

/// Converts Box2D's results to the plane's motions.
void take_results(const World& world, Planar& all, Real h) {
  begin_motions(all, h);
  const std::vector<PlaneBody>& bodies = all.scratch.plane.bodies;
  PANTIN_ASSERT(bodies.size() == all.bodies.size() + 1);
  Motions& m = all.scratch.motions;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const PlaneBody& b = bodies[i];
    if (b.kind == PlaneBody::kinematic)
      m.position[i] = {b.position.x, b.position.y, b.angle}, m.gained[i] = 0;
    if (b.kind != PlaneBody::dynamic) continue;
    m.position[i] += Vec3(b.moved.x, b.moved.y, b.turned);
    m.velocity[i] += Vec3(b.sped_up.x, b.sped_up.y, b.spun_up);
    m.velocity[i] *= std::exp(-world.bodies.values()[all.bodies[i].slot].drag * h);
    m.gained[i] = b.turned;
  }
}

/// A body whose motion is not finite, or none.
Entity find_lost(const Planar& all) {
  const Motions& m = all.scratch.motions;
  const auto fits = [](Vec3 v) { return glm::dot(v, v) < kWidest * kWidest; };
  for (std::size_t i = 0; i < all.bodies.size(); ++i)
    if (!fits(m.position[i]) || !fits(m.velocity[i])) return all.bodies[i].body;
  return {};
}

void write_bodies(World& world, Planar& all) {
  const Motions& m = all.scratch.motions;
  for (std::size_t i = 0; i < all.bodies.size(); ++i) {
    FlatBody& f = all.bodies[i];
    if (f.island == kNobody) continue;
    Body& b = world.bodies.values()[f.slot];
    f.turned = m.position[i].z;
    b.pose.position.x = m.position[i].x, b.pose.position.y = m.position[i].y;
    const Real half = 0.5 * std::remainder(f.turned, 2 * kPi);
    b.pose.rotation = glm::normalize(Quat(std::cos(half), 0, 0, std::sin(half)) * f.tilt);
    b.velocity = {m.velocity[i].x, m.velocity[i].y, 0};
    b.angular_velocity = {0, 0, m.velocity[i].z};
    b.restart = b.teleport = false;
  }
  for (const FlatPin& p : all.pins) {
    Pin& pin = world.pins.values()[p.pin];
    pin.residual = gap_of(world, all, p);
    pin.missed = pin.residual > 1e-4 * std::max(all.scratch.plane.unit, 1e-3);
    pin.reachable = !pin.missed;
  }
}

/// Stores the reactions of links, and the warm start of joints.
void keep_loads(Planar& all) {
  const StepScratch& s = all.scratch;
  PANTIN_ASSERT(s.joint_of.size() == all.links.size());
  all.reactions.assign(all.links.size(), {});
  for (const Mechanism& of : all.mechanisms) {
    std::size_t joint = 0;
    for (const std::uint32_t link : of.links)
      if (s.joint_of[link] != kNobody) all.reactions[link] = of.borne[joint++];
  }
  const std::vector<PlaneJoint>& joints = s.plane.joints;
  for (std::size_t i = 0; i < all.links.size(); ++i)
    if (const std::uint32_t at = s.joint_of[i]; at != kNobody) all.loads[i] = joints[at].load;
  for (std::size_t i = 0; i < all.pins.size(); ++i)
    all.loads[all.links.size() + i] = joints[joints.size() - all.pins.size() + i].load;
}

void name_shapes(const Plane& plane, PlaneContact& t) {
  PANTIN_ASSERT(t.outline_a < plane.bodies[t.a].count && t.outline_b < plane.bodies[t.b].count);
  t.shape_a = plane.outlines[plane.bodies[t.a].first + t.outline_a].shape;
  t.shape_b = plane.outlines[plane.bodies[t.b].first + t.outline_b].shape;
}

/// Steps bodies with contacts by Box2D.
void collide_bodies(const World& world, Planar& all, const StepTask& task) {
  Plane& plane = all.scratch.plane;
  plane.filter = task.filter;
  plane.near = contact::has_near_pairs(world, task.filter) ? &all.near : nullptr;
  all.near.begin();
  if (plane.near) contact::add_ignored(world, plane.ignored, all.near);
  step_clusters(plane, task.h, all.touches);
  PANTIN_ASSERT(std::is_sorted(all.touches.begin(), all.touches.end(), comes_before));
  all.near.end([](const contact::NearPair&) { return false; });
}

void predict(World& world, const StepTask& task) {
  Planar& all = plane_of(world);
  all.scratch.stepped = false;
  all.residual = 0;
  all.lost = all.lost_contact = {};
  if (all.islands == 0) return;
  read_turns(world, all);
  all.scratch.h = task.h;
  if (rests(world, all, task.h)) return;
  gather(world, all);
  StepScratch& scratch = all.scratch;
  if (const std::uint32_t unfit = find_unfit(scratch.plane); unfit != kNobody) {
    all.lost = all.bodies[std::min<std::size_t>(unfit, all.bodies.size() - 1)].body;
    return;
  }
  count_coordinates(world, all), begin_motions(all, task.h), begin_belts(world, all);
  begin_drives(world, all, task.h);
  scratch.starts.clear();
  for (const FlatBody& f : all.bodies) scratch.starts.push_back(world.bodies.values()[f.slot].pose);
  scratch.touches_before = all.touches, scratch.curves_before = all.curves;
  move_mechanisms(world, all, task.h);
  drive_tied(world, all, task.h);
  collide_bodies(world, all, task);
  for (PlaneContact& t : all.touches) name_shapes(scratch.plane, t);
  take_results(world, all, task.h);
  take_mechanisms(all);
  take_drives(world, all, task.h);
  scratch.motions.time = task.h;
  close(world, all, task.h);
  find_lost_curves(world, all);
  if (!all.lost_contact) all.lost = find_lost(all);
  if (all.lost) {
    all.touches = scratch.touches_before, all.curves = scratch.curves_before;
    return;
  }
  keep_loads(all);
  write_drives(world, all, task.h);
  write_bodies(world, all), end_belts(world, all, task.h);
  write_curves(world, all);
  note_stillness(world, all);
  all.scratch.stepped = true;
}

/// What is wrong with a saved World that was read, or null.
const char* fault(const World& world) {
  const Planar& all = plane_of(world);
  for (const PlaneContact& t : all.touches)
    if (std::max(t.a, t.b) >= all.bodies.size())
      return "contains a contact of a body that does not exist";
  for (const FlatBody& f : all.bodies)
    if (!std::isfinite(f.turned) || !is_unit(Pose{Vec3(0), f.tilt}))
      return "contains a rotation that is not a unit quaternion";
  return nullptr;
}

bool asleep(const World& world) {
  const Planar& all = plane_of(world);
  return all.islands == 0 || !all.scratch.stepped;
}

/// All bodies of the plane sleep together.
bool sleeps(const World& world, std::size_t) {
  const Planar& all = plane_of(world);
  return all.scratch.h > 0 && !all.scratch.stepped && !all.lost && all.still > 0;
}

/// Bodies of the plane are obstacles, already at the end of the step.
void find_starts(const World& world, std::vector<contact::StartPose>& out) {
  const Planar& all = plane_of(world);
  for (std::size_t i = 0; i < all.bodies.size() && all.scratch.stepped; ++i)
    if (all.bodies[i].island != kNobody && all.bodies[i].solid)
      out.push_back({all.bodies[i].slot, all.scratch.starts[i]});
}

Contact contact_of(const World& world, const Planar& all, const PlaneContact& t) {
  PANTIN_ASSERT(t.a < all.bodies.size() && t.b < all.bodies.size());
  const FlatBody &a = all.bodies[t.a], &b = all.bodies[t.b];
  const Body &on_a = world.bodies.values()[a.slot], &on_b = world.bodies.values()[b.slot];
  Contact c;
  c.slot_a = a.slot, c.slot_b = b.slot, c.normal = t.normal, c.depth = t.depth;
  // Shapes have few outlines; with more than 64 some share a key.
  const std::uint64_t outlines = (t.outline_a & 0x3f) << 6 | (t.outline_b & 0x3f);
  const bool is_a = a.island != kNobody;
  c.key = contact::key_of(is_a ? t.shape_a : t.shape_b, is_a ? t.shape_b : t.shape_a,
                          outlines << 32 | t.feature);
  const Vec3 at(t.point.x, t.point.y, 0.5 * (on_a.pose.position.z + on_b.pose.position.z));
  c.point_a = to_local(on_a.pose, at), c.point_b = to_local(on_b.pose, at);
  c.active = t.impulse != Vec3(0), c.gap = t.ended ? 1e-3 : -t.depth;
  c.force = all.scratch.h > 0 ? t.impulse / all.scratch.h : Vec3(0);
  if (a.island != kNobody) return c;
  std::swap(c.slot_a, c.slot_b), std::swap(c.point_a, c.point_b);
  c.normal = -c.normal, c.force = -c.force;
  return c;
}

/// Lists contacts of two bodies that no other solver moves, in the order of bodies.
void list_contacts(const World& world, std::vector<Contact>& to) {
  const Planar& all = plane_of(world);
  if (all.islands == 0) return;
  const Partition& partition = partition_of(world);
  std::erase_if(to, [&](const Contact& c) {  // left from an earlier step while all were asleep
    return !contact::feels_contacts(partition, c.slot_a) &&
           !contact::feels_contacts(partition, c.slot_b);
  });
  for (const PlaneContact& t : all.touches) to.push_back(contact_of(world, all, t));
  std::stable_sort(to.begin(), to.end(), [](const Contact& p, const Contact& q) {
    return std::tie(p.slot_a, p.slot_b, p.key) < std::tie(q.slot_a, q.slot_b, q.key);
  });
}

void note_failure(const World& world, StepReport& report) {
  const Planar& all = plane_of(world);
  if (!all.lost || report.status == Status::diverged) return;
  if (all.lost_contact) {
    report.status = Status::contact_lost, report.body = all.lost;
    report.contact = all.lost_contact, report.contact_fault = nurbs::word_of(all.lost_how);
    return;
  }
  report.status = Status::diverged, report.body = all.lost, report.residual = all.residual;
}

void report(const World& world, StepReport& report) {
  const Planar& all = plane_of(world);
  report.worst_constraint = std::max(report.worst_constraint, all.residual);
  for (const FlatDrive& d : all.drives) {
    report.drives_capped += d.lag.limited;
    // Without a maximum it moves its joint beyond the limit.
    const bool contradicts = d.beyond != 0 && !has_most(world.joint_drives.values()[d.drive]);
    if (!contradicts || report.status != Status::ok) continue;
    report.status = Status::inconsistent;
    report.worst_residual_at = d.owner, report.worst_residual = std::abs(d.beyond);
  }
  if (all.islands > 0 && !all.scratch.stepped && !all.lost)
    report.asleep += static_cast<int>(all.islands);
}

/// J: energy of the springs along the coordinates of a joint.
Real energy_of_springs(const World& world, const FlatLink& l) {
  const Link& link = world.links.values()[l.link];
  Real sum = 0;
  for (const Coordinate which : {Coordinate::angle, Coordinate::travel}) {
    const bool turns = which == Coordinate::angle;
    const JointParameters& own = *link.joint.parameters;
    const SpringDamper& spring = turns ? own.rotation.spring : own.translation.spring;
    if (!(spring.stiffness > 0) || !info_of(link.joint.kind).find(which)) continue;
    const Real near = turns ? angle_near(link.joint, l) : 0;
    sum += energy_of(spring, coordinate_at(world, link, which, near).value);
  }
  return sum;
}

void measure(const World& world, Measures& m) {
  const Planar& all = plane_of(world);
  Real size = 1e-3;
  for (const FlatBody& f : all.bodies) size = std::max(size, extent_of(world, f));
  for (const FlatLink& l : all.links) {
    const Link& link = world.links.values()[l.link];
    const Pose &a = world.bodies[link.a].pose, &b = world.bodies[link.b].pose;
    const Real gap = info_of(link.joint.kind).gap(link.joint, a, b);
    if (gap > m.worst_gap) m.worst_gap = gap, m.worst_link = world.links.owners()[l.link];
    m.worst_gap_rel = std::max(m.worst_gap_rel, gap / size);
    m.elastic += energy_of_springs(world, l);
  }
}

void list_turns(const World& world, TurnCounts& counts) {
  for (const FlatLink& l : plane_of(world).links)
    if (l.angle != 0) counts.push_back({l.owner, Coordinate::angle, l.angle});
}

Real drive_angle(const World& world, Entity joint) {
  for (const FlatDrive& d : plane_of(world).drives)
    if (d.owner == joint && !d.travels) return d.value;
  return std::numeric_limits<Real>::quiet_NaN();
}

}  // namespace

const SolverRow kRow{.name = "planar",
                     .compile = compile,
                     .list_turns = list_turns,
                     .predict = predict,
                     .fault = fault,
                     .asleep = asleep,
                     .sleeps = sleeps,
                     .find_starts = find_starts,
                     .list_contacts = list_contacts,
                     .note_failure = note_failure,
                     .report = report,
                     .measure = measure,
                     .drive_angle = drive_angle};

}  // namespace pantin::detail::planar

namespace pantin::detail {
template planar::Planar& Memories::create();
template const planar::Planar& Memories::none();
}  // namespace pantin::detail
