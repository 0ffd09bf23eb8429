#include "engine/render/marks.hpp"

#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/contact/contact.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/render/bounds.hpp"
#include "engine/world/partition.hpp"

namespace pantin::detail {
namespace {

constexpr Real kNoCap = 1e100;  // N m; joint drives above it have no torque limit

/// Colours are given in sRGB; legends are linear [IEC 61966-2-1].
Vec3 linear(Vec3 srgb) {
  const auto part = [](Real x) {
    return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
  };
  return {part(srgb.x), part(srgb.y), part(srgb.z)};
}

void add_body_axes(const PosedWorld& scene, Pen& pen) {
  const Real pixels = std::max(8.0, pen.eye().height / 48.0);
  for (std::uint32_t slot = 0; slot < scene.world.bodies.size(); ++slot) {
    const Pose& pose = scene.pose_of(slot);
    if (!is_finite(pose) || !pen.sees(pose.position)) continue;
    for (int k = 0; k < 3; ++k) {
      Vec3 tip{0};
      tip[k] = pen.metres(pose.position, pixels);
      pen.line(pose.position, to_world(pose, tip), 1.2 * pen.fine(), ink::kAxes[k]);
    }
  }
}

void add_slack_cables(const PosedWorld& scene, Pen& pen) {
  std::vector<Vec3> curve;
  for (const Cable& cable : scene.world.cables.values()) {
    curve.clear();
    add_cable(scene, cable, 24, curve);
    if (curve.size() > 2 && cable.guides.empty()) pen.path(curve, 1.2 * pen.fine(), ink::kSlack);
  }
}

void add_joint_rings(const PosedWorld& scene, Pen& pen) {
  for (const Link& link : scene.world.links.values()) {
    const auto a = scene.position_of(link.a, link.joint.anchor_a);
    const auto b = scene.position_of(link.b, link.joint.anchor_b);
    if (!a || !b || !pen.sees(*a) || !pen.sees(*b)) continue;
    const Vec3 gap = pen.eye().project(*b) - pen.eye().project(*a);
    const bool meets = holds_point(link.joint.kind);  // other kinds have lines of their own
    if (meets && std::hypot(gap.x, gap.y) > 0.5) pen.line(*a, *b, 2 * pen.fine(), ink::kOpenJoint);
    const Vec3 at = info_of(link.joint.kind).binds_poses() ? *a : *b;
    pen.ring(at, std::max(4.0, pen.eye().height / 110.0), pen.fine(), ink::kJoint);
  }
}

void add_pins(const PosedWorld& scene, Pen& pen) {
  const World& world = scene.world;
  if (world.pins.empty()) return;
  const Real size = std::max(3.0, pen.eye().height / 160.0);
  for (const Pin& pin : world.pins.values()) {
    const auto at = scene.position_of(pin.body, pin.anchor);
    const auto target = pin.to ? scene.position_of(pin.to, pin.target) : pin.target;
    if (!at || !target) continue;
    const bool missed = !pin.reachable || pin.missed;
    const Vec3 colour = missed ? ink::kWarning : ink::kPin;
    pen.dot(*at, size, colour);
    pen.line(*at, *target, pen.fine(), colour);
    pen.cross(*target, size, 1.4 * pen.fine(), colour);
    if (missed) pen.ring(*target, 1.9 * size, pen.fine(), colour);
  }
}

/// The mean weight of an island, N: the unit for drawing forces.
Real usual_weight(const World& world) {
  Real mass = 0;
  for (const Body& body : world.bodies.values())
    if (body.motion == Motion::dynamic) mass += body.mass;
  const Real pull = glm::length(world.gravity);
  const auto count =
      static_cast<Real>(std::max<std::size_t>(partition_of(world).islands.size(), 1));
  return mass * (pull > 0 ? pull : 9.81) / count;
}

/// The drawn length of a force: proportional to log(1 + 9 force / weight). A force of one unit is a
/// tenth of the picture's height; the maximum is three tenths.
struct ForceScale {
  Real weight, whole;  // N, m

  ForceScale(const World& world, const Eye& eye)
      : weight(std::max(usual_weight(world), 1e-12)),
        whole(eye.height / 10.0 * eye.pixel() * eye.distance) {}
  Real length(Real force) const {
    return whole * std::min(std::log10(1 + 9 * force / weight), 3.0);
  }
};

/// Fraction of the torque limit; without a limit, of the spring's torque at half a turn.
Real effort(const JointDrive& drive) {
  const Real most = drive.max_torque < kNoCap ? drive.max_torque : kPi * drive.stiffness;
  return most > 0 ? std::clamp(std::abs(drive.torque) / most, 0.0, 1.0) : 0;
}

/// An arc about the axis of the remaining rotation; three quarters of a circle correspond to the
/// torque limit.
void add_muscle(const PosedWorld& scene, const JointDrive& drive, const Link& link, Pen& pen) {
  const World& world = scene.world;
  const auto anchor = scene.position_of(link.a, link.joint.anchor_a);
  if (!anchor || !pen.sees(*anchor)) return;
  const Vec3 at = *anchor;
  const std::uint32_t b = world.bodies.slot(link.b);
  const Real size = mark_size(scene, link, at, pen);
  if (size <= 0 || b == kNoSlot) return;
  const Quat turn_a = scene.pose_of(world.bodies.slot(link.a)).rotation;
  const Quat now = relative_rotation(link.joint, turn_a, scene.pose_of(b).rotation);
  const Vec3 rest = drive.exact
                        ? Vec3(drive.torque < 0 ? -1 : 1, 0, 0)
                        : rotation_vector(target_at(drive, world.time) * glm::conjugate(now));
  const Real angle = glm::length(rest);
  const Vec3 axis = turn_a * link.joint.frames.a() * (angle > 1e-6 ? rest / angle : Vec3{1, 0, 0});
  // It starts at the side, so that short arcs are not seen edge-on.
  Vec3 side = glm::cross(axis, pen.eye().forward);
  if (glm::length(side) < 1e-3) side = glm::cross(axis, pen.eye().up);
  const Real radius = 0.45 * size, sweep = std::max(0.12, 1.5 * kPi * effort(drive));
  const Arc arc{at, axis, radius * glm::normalize(side), 0, sweep};
  const std::vector<Vec3> points = points_of(arc);
  const Vec3 colour = drive.capped ? ink::kWarning : ink::kMuscle;
  pen.path(points, 2 * pen.fine(), colour);
  const Vec3 tip = points.back(), out = glm::normalize(tip - at);
  const Vec3 back = 0.22 * radius * glm::cross(out, axis);
  pen.line(tip, tip + back + 0.16 * radius * out, 2 * pen.fine(), colour);
  pen.line(tip, tip + back - 0.16 * radius * out, 2 * pen.fine(), colour);
}

void add_muscles(const PosedWorld& scene, Pen& pen) {
  const World& world = scene.world;
  for (std::size_t i = 0; i < world.joint_drives.size(); ++i)
    if (const Link* link = world.links.find(world.joint_drives.owners()[i]);
        link && !world.joint_drives.values()[i].motion.travels)
      add_muscle(scene, world.joint_drives.values()[i], *link, pen);
}

}  // namespace

void Pen::line(Vec3 a, Vec3 b, Real width, const Paint& paint) {
  if (sees(a) && sees(b)) list_.add_line(eye_.project(a), eye_.project(b), width, paint);
}

void Pen::dot(Vec3 centre, Real radius, Vec3 colour) {
  if (sees(centre)) list_.add_box(eye_.project(centre), {radius, radius, 0}, radius, colour);
}

void Pen::square(Vec3 centre, Real half, Vec3 colour) {
  if (sees(centre)) list_.add_box(eye_.project(centre), {half, half, 0}, 0.2 * half, colour);
}

void Pen::ring(Vec3 centre, Real radius, Real width, Vec3 colour) {
  if (sees(centre)) list_.add_ring(eye_.project(centre), radius, width, colour);
}

void Pen::cross(Vec3 centre, Real reach, Real width, Vec3 colour) {
  if (!sees(centre)) return;
  const Vec3 at = eye_.project(centre);
  for (Real sign : {1.0, -1.0}) {
    const Vec3 arm{reach, sign * reach, 0};
    list_.add_line(at - arm, at + arm, width, colour);
  }
}

void Pen::triangle(Vec3 a, Vec3 b, Vec3 c, const Paint& paint) {
  if (sees(a) && sees(b) && sees(c))
    list_.add_triangle(eye_.project(a), eye_.project(b), eye_.project(c), paint);
}

void Pen::path(std::span<const Vec3> points, Real width, const Paint& paint) {
  for (std::size_t i = 1; i < points.size(); ++i) line(points[i - 1], points[i], width, paint);
}

void Pen::fan(Vec3 apex, std::span<const Vec3> rim, Vec3 colour) {
  for (std::size_t i = 1; i < rim.size(); ++i) triangle(apex, rim[i - 1], rim[i], {colour, 0.16});
}

std::vector<Vec3> points_of(const Arc& arc) {
  constexpr Real kStep = 0.13;  // rad; finer steps are invisible at the size of marks
  const int pieces = std::max(1, static_cast<int>(std::ceil((arc.high - arc.low) / kStep)));
  std::vector<Vec3> points;
  for (int i = 0; i <= pieces; ++i) {
    const Real angle = arc.low + (arc.high - arc.low) * i / pieces;
    points.push_back(arc.centre + from_rotation_vector(angle * arc.axis) * arc.zero);
  }
  return points;
}

Real mark_size(const PosedWorld& scene, const Link& link, Vec3 at, const Pen& pen) {
  if (!pen.sees(at)) return 0;
  const Real pixel = pen.metres(at, 1), height = pen.eye().height;
  const Real body =
      0.7 * std::min(drawn_reach(scene.world, link.a), drawn_reach(scene.world, link.b));
  if (body < height / 200 * pixel) return 0;
  return std::clamp(body, height / 36 * pixel, height / 8 * pixel);
}

/// Whether the friction of a contact is at its limit.
bool slides(const Contact& contact) {
  const Real normal = glm::dot(contact.force, contact.normal);
  const Real across = glm::length(contact.force - normal * contact.normal);
  return across > (1 - 1e-6) * contact.friction * normal;
}

void add_contact_marks(const PosedWorld& scene, Pen& pen) {
  const World& world = scene.world;
  if (contacts_of(world).empty() && resting_contacts_of(world).empty()) return;
  const ForceScale scale(world, pen.eye());
  each_contact(world, [&](const Contact& contact) {
    if (contact.slot_a >= world.bodies.size()) return;
    const Vec3 at = to_world(scene.pose_of(contact.slot_a), contact.point_a);
    if (!contact.active) {
      pen.dot(at, 1.4 * pen.fine(), ink::kNear);
      return;
    }
    const Real force = glm::length(contact.force);
    if (force > 0)
      pen.line(at, at + scale.length(force) / force * contact.force, 1.6 * pen.fine(),
               ink::kContact);
    pen.dot(at, 2.6 * pen.fine(), ink::kContact);
    if (slides(contact)) pen.cross(at, 4 * pen.fine(), 1.3 * pen.fine(), ink::kSlide);
  });
}

void add_forces(const World& world, std::span<const Overlay::Arrow> forces, Pen& pen) {
  if (forces.empty()) return;
  const ForceScale scale(world, pen.eye());
  for (const Overlay::Arrow& arrow : forces) {
    const Real force = glm::length(arrow.force);
    if (!(force > 0) || !is_finite(arrow.force) || !pen.sees(arrow.at)) continue;
    const Vec3 way = arrow.force / force, tip = arrow.at + scale.length(force) * way;
    if (!pen.sees(tip)) continue;
    pen.line(arrow.at, tip, 1.6 * pen.fine(), ink::kForce);
    // The arrow head is in the plane of the picture.
    const Vec3 side = glm::cross(way, pen.eye().forward);
    const Real head = std::min(pen.metres(tip, 6 * pen.fine()), 0.5 * scale.length(force));
    if (glm::length(side) < 1e-3) continue;
    const Vec3 out = 0.45 * head * glm::normalize(side), back = tip - head * way;
    pen.triangle(tip, back + out, back - out, ink::kForce);
  }
}

void add_doubts(std::span<const Vec3> places, Pen& pen) {
  for (const Vec3 at : places)
    if (pen.sees(at)) pen.ring(at, 9 * pen.fine(), 1.6 * pen.fine(), ink::kWarning);
}

void add_marks(const PosedWorld& scene, Pen& pen) {
  add_body_axes(scene, pen);
  add_slack_cables(scene, pen);
  add_turn_marks(scene, pen);
  add_joint_rings(scene, pen);
  add_muscles(scene, pen);
  add_pins(scene, pen);
  add_contact_marks(scene, pen);
  add_surface_marks(scene, pen);
}

}  // namespace pantin::detail

namespace pantin {

using namespace detail;

namespace {

void name_contacts(const World& world, std::vector<LegendEntry>& entries) {
  if (world.collisions.empty() && contacts_of(world).empty()) return;
  entries.push_back({linear(ink::kContact), "dot, line: contact and its force"});
  entries.push_back({linear(ink::kSlide), "cross on a dot: sliding contact"});
  entries.push_back({linear(ink::kNear), "small dot: about to touch"});
}

}  // namespace

std::vector<LegendEntry> forces_legend(const World& world) {
  std::vector<LegendEntry> entries;
  if (!world.links.empty() || !world.cables.empty() || !world.pins.empty())
    entries.push_back({linear(ink::kForce), "arrow: force of a joint, cable or pin"});
  name_contacts(world, entries);
  return entries;
}

std::vector<LegendEntry> overlay_legend(const World& world) {
  bool ranges = false, axes = false, locks = false, slides = false, springs = false, rods = false,
       stops = false, slips = false;
  const auto is_lock = [](const AngleLimit& l) { return l.on && !(l.high > l.low); };
  for (const Link& link : world.links.values()) {
    const JointLimits& limits = link.joint.limits;
    ranges |= limits.any();
    for (const Mark mark : info_of(link.joint.kind).marks) {
      slides |= mark == Mark::translation, rods |= mark == Mark::rod,
          springs |= mark == Mark::zigzag, slips |= mark == Mark::slip;
      axes |= mark == Mark::axis_x || mark == Mark::axis_y || mark == Mark::axis_z;
      locks |= mark == Mark::lock;
    }
    stops |= limits.any() || link.joint.parameters->travel.on;
    locks |= is_lock(limits.angle) || is_lock(limits.second) ||
             (limits.swing.on && limits.swing.y <= 0 && limits.swing.z <= 0);
  }
  std::vector<LegendEntry> entries;
  const auto name = [&](Vec3 colour, const std::string& text) {
    entries.push_back({linear(colour), text});
  };
  if (!world.links.empty()) name(ink::kJoint, "ring: joint");
  if (axes) name(ink::kHinge, "line: hinge axis");
  if (slides) name(ink::kTie, "line: axis of translation");
  if (rods) name(ink::kTie, "line: constant distance");
  if (slips) name(ink::kTie, "line: axle of a wheel, across a blade");
  if (springs) name(ink::kTie, "zigzag: spring");
  if (ranges) name(ink::kRange, "fan, arc: range of a joint");
  if (locks) name(ink::kLocked, "square: locked");
  if (!world.cables.empty()) name(ink::kSlack, "curve: slack cable");
  if (!world.surface_contacts.empty()) {
    name(ink::kContact, "plane, line: surface contact, its normal");
    name(ink::kTrailA, "curve: path of the contact on a");
    name(ink::kTrailB, "curve: path of the contact on b");
  }
  if (!world.pins.empty()) name(ink::kPin, "cross: pin");
  if (!world.joint_drives.empty()) name(ink::kMuscle, "arrow: torque of a joint drive");
  name_contacts(world, entries);
  std::string red;
  const auto warn = [&](const char* text) {
    red += (red.empty() ? "red: " : ", ") + std::string(text);
  };
  if (stops) warn("at a stop");
  if (!world.pins.empty()) warn("out of reach");
  if (!world.joint_drives.empty()) warn("at maximum torque");
  if (!red.empty()) name(ink::kWarning, red);
  return entries;
}

}  // namespace pantin
