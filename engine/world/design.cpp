#include "engine/world/design.hpp"

#include <algorithm>

#include "engine/joints/kinds.hpp"
#include "engine/nurbs/curve_pair.hpp"
#include "engine/nurbs/net.hpp"
#include "engine/world/belt.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {
namespace {

/// The anchor of a joint or cable.
template <class Tie>
auto& anchor_of(Tie& tie, Quantity quantity) {
  return quantity == Quantity::anchor_a ? tie.joint.anchor_a : tie.joint.anchor_b;
}

}  // namespace

std::string_view design_fault(const Joint& joint, Quantity quantity) {
  switch (quantity) {
    case Quantity::length:
      if (joint.kind != JointKind::distance)
        return "expected the length of a distance joint or of a cable";
      return {};
    case Quantity::radius:
      return "expected the radius of a pulley of a cable or belt";
    case Quantity::pitch:
      if (joint.kind != JointKind::screw) return "expected the pitch of a screw joint";
      return {};
    case Quantity::anchor_a:
    case Quantity::anchor_b:
      if (joint.kind == JointKind::custom || joint.kind == JointKind::spring)
        return "expected an anchor of a joint whose equations constrain it";
      return {};
    case Quantity::axis_a:
    case Quantity::axis_b:
      if (!info_of(joint.kind).uses_axes) return "expected an axis of a joint that has one";
      return {};
    default:  // of other laws
      return "expected a number of a joint";
  }
}

std::string_view design_fault(const CableParameters& cable, Quantity quantity, Real radius) {
  if (cable.compliance > 0) return "expected a cable that is inextensible, without \"compliance\"";
  switch (quantity) {
    case Quantity::pitch:
      return "expected the pitch of a screw joint";
    case Quantity::axis_a:
    case Quantity::axis_b:
      return "expected an axis of a joint";
    case Quantity::radius:
      if (!(radius > 0)) return "expected the number of a pulley of the cable, with a \"radius\"";
      return {};
    case Quantity::length:
    case Quantity::anchor_a:
    case Quantity::anchor_b:
      return {};
    default:  // of other laws
      return "expected a number of a cable";
  }
}

std::string_view design_fault(const Gear& gear, Quantity quantity) {
  if (quantity != Quantity::ratio) return "expected the ratio of a gear";
  if (!gear.has_offset)
    return "expected a gear with an \"offset\": without one every ratio fits as it is placed";
  return {};
}

std::string_view design_fault(const Belt& belt, Quantity quantity, std::uint32_t pulley) {
  if (quantity != Quantity::radius) return "expected the radius of a pulley";
  if (pulley >= belt.pulleys.size() || !belt.pulleys[pulley].outline.corners.empty())
    return "expected the number of a pulley of the belt, with a \"radius\"";
  return {};
}

namespace {

bool is_on_b(Quantity q) { return q == Quantity::point_b || q == Quantity::weight_b; }

}  // namespace

std::string_view design_fault(const SurfaceContact& contact, const DesignVariable& v) {
  if (!is_point(v.quantity) && !is_weight(v.quantity))
    return "expected a control point or a weight of a surface or curve";
  if (contact.on_a.curve && contact.on_b.curve && contact.motion != SurfaceMotion::sliding)
    return "expected a curve that slides: the arc length of one that rolls depends on all its "
           "points";
  const ContactSurface& on = is_on_b(v.quantity) ? contact.on_b : contact.on_a;
  constexpr std::string_view kNone = "expected the number of a control point";
  if (on.curve) return v.guide < on.curve->curve().points.size() ? std::string_view() : kNone;
  if (on.skin->half_axes()) return "expected a surface that has control points";
  if (v.face >= on.skin->faces().size() ||
      v.guide >= on.skin->face(static_cast<int>(v.face)).surface().points.size())
    return kNone;
  return {};
}

const ContactSurface& surface_of(const World& world, const DesignVariable& v) {
  const SurfaceContact& contact = world.surface_contacts[v.law];
  return is_on_b(v.quantity) ? contact.on_b : contact.on_a;
}

const LaidBelt* laid_of(const World& world, Entity belt) {
  const Store<LaidBelt>* all = world.user.find<LaidBelt>();
  return all ? all->find(belt) : nullptr;
}

bool is_same_net(const ContactSurface& one, const ContactSurface& other) {
  if (one.skin || other.skin) return one.skin == other.skin;
  return one.curve == other.curve || one.curve->curve().points == other.curve->curve().points;
}

std::string_view fault_of(const World& world, const DesignVariable& v) {
  if (const Link* link = world.links.find(v.law)) return design_fault(link->joint, v.quantity);
  if (const Gear* gear = world.gears.find(v.law)) return design_fault(*gear, v.quantity);
  if (const Belt* belt = world.belts.find(v.law)) return design_fault(*belt, v.quantity, v.guide);
  if (const SurfaceContact* contact = world.surface_contacts.find(v.law))
    return design_fault(*contact, v);
  const Cable* cable = world.cables.find(v.law);
  if (!cable) return "expected a joint, a cable, a gear, a belt or a surface joint";
  const Real radius = v.guide < cable->guides.size() ? cable->guides[v.guide].radius : -1;
  return design_fault(cable->joint, v.quantity, radius);
}

namespace {

DesignValue value_of(const Link& link, Quantity q) {
  const JointFrames& frames = link.joint.frames;
  if (q == Quantity::length) return {Vec3(link.joint.parameters->length, 0, 0)};
  if (q == Quantity::pitch) return {Vec3(link.joint.parameters->pitch, 0, 0)};
  if (q == Quantity::axis_a) return {Vec3(0), frames.a()};
  if (q == Quantity::axis_b) return {Vec3(0), frames.b()};
  return {anchor_of(link, q)};
}

void set_value(Joint& joint, Quantity q, const DesignValue& value) {
  if (q == Quantity::length)
    joint.parameters.edit().length = value.numbers.x;
  else if (q == Quantity::pitch)
    joint.parameters.edit().pitch = value.numbers.x;
  else if (q == Quantity::axis_a)
    joint.frames.set_a(value.axes);
  else if (q == Quantity::axis_b)
    joint.frames.set_b(value.axes);
  else
    (q == Quantity::anchor_a ? joint.anchor_a : joint.anchor_b) = value.numbers;
}

/// Its marks keep their places: each offset changes as it does where the belt was laid.
void set_radius(World& world, const DesignVariable& v, Real radius) {
  Belt& belt = world.belts[v.law];
  const LaidBelt* laid = laid_of(world, v.law);
  Belt before = belt;
  belt.pulleys[v.guide].outline.radius = radius;
  if (!laid) return;
  Belt after = belt;
  if (!lay_belt(before, laid->bodies) || !lay_belt(after, laid->bodies)) return;
  for (std::size_t i = 0; i < belt.pulleys.size(); ++i)
    belt.pulleys[i].offset += after.pulleys[i].offset - before.pulleys[i].offset;
}

const nurbs::Weighted& control_point(const ContactSurface& on, const DesignVariable& v) {
  if (on.curve) return on.curve->curve().points[v.guide];
  return on.skin->face(static_cast<int>(v.face)).surface().points[v.guide];
}

/// The surface or curve with another control point.
ContactSurface with_control_point(const ContactSurface& on, const DesignVariable& v,
                                  const nurbs::Weighted& to) {
  ContactSurface made = on;
  if (on.curve) {
    const nurbs::Curve& curve = on.curve->curve();
    made.curve = std::make_shared<const nurbs::Wire>(
        nurbs::with_point(curve, nurbs::images_of(curve, v.guide), to));
    return made;
  }
  std::vector<nurbs::Surface> faces;
  for (const nurbs::Face& face : on.skin->faces()) faces.push_back(face.surface());
  nurbs::Surface& face = faces[v.face];
  face = nurbs::with_point(face, nurbs::images_of(face, v.guide), to);
  made.skin = std::make_shared<const nurbs::Skin>(std::move(faces), on.skin->tolerance());
  return made;
}

void set_control_point(World& world, const DesignVariable& v, Vec3 numbers) {
  const ContactSurface before = surface_of(world, v);
  const nurbs::Weighted& was = control_point(before, v);
  const nurbs::Weighted to = is_weight(v.quantity) ? nurbs::Weighted(was.point(), numbers.x)
                                                   : nurbs::Weighted(numbers, was.w);
  const ContactSurface made = with_control_point(before, v, to);
  for (SurfaceContact& contact : world.surface_contacts.values())
    for (ContactSurface* on : {&contact.on_a, &contact.on_b})
      if (is_same_net(*on, before)) on->skin = made.skin, on->curve = made.curve;
}

}  // namespace

nurbs::Weighted control_point_of(const World& world, const DesignVariable& v) {
  return control_point(surface_of(world, v), v);
}

DesignValue value_of(const World& world, const DesignVariable& v) {
  const Quantity q = v.quantity;
  if (const Link* link = world.links.find(v.law)) return value_of(*link, q);
  if (const Gear* gear = world.gears.find(v.law)) return {Vec3(gear->ratio, 0, 0)};
  if (const Belt* belt = world.belts.find(v.law))
    return {Vec3(belt->pulleys[v.guide].outline.radius, 0, 0)};
  if (world.surface_contacts.find(v.law)) {
    const nurbs::Weighted point = control_point_of(world, v);
    return {is_weight(q) ? Vec3(point.w, 0, 0) : point.point()};
  }
  const Cable& cable = world.cables[v.law];
  if (q == Quantity::length) return {Vec3(cable.joint.length, 0, 0)};
  if (q == Quantity::radius) return {Vec3(cable.guides[v.guide].radius, 0, 0)};
  return {anchor_of(cable, q)};
}

void set_value(World& world, const DesignVariable& v, const DesignValue& value) {
  const Quantity q = v.quantity;
  if (Link* link = world.links.find(v.law)) return set_value(link->joint, q, value);
  if (Gear* gear = world.gears.find(v.law)) {
    gear->ratio = value.numbers.x;
    return;
  }
  if (world.belts.find(v.law)) return set_radius(world, v, value.numbers.x);
  if (world.surface_contacts.find(v.law)) return set_control_point(world, v, value.numbers);
  Cable& cable = world.cables[v.law];
  if (q == Quantity::length)
    cable.joint.length = value.numbers.x;
  else if (q == Quantity::radius)
    cable.guides[v.guide].radius = value.numbers.x;
  else
    anchor_of(cable, q) = value.numbers;
}

}  // namespace pantin::detail
