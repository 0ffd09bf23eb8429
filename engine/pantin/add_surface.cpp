// Joints of surfaces in contact.
#include <pantin/joints.hpp>

#include "engine/geometry/shape_skin.hpp"
#include "engine/nurbs/check.hpp"
#include "engine/nurbs/makers.hpp"
#include "engine/nurbs/plane_curves.hpp"
#include "engine/pantin/detail/findings.hpp"
#include "engine/world/solver_list.hpp"
#include "engine/world/surface_start.hpp"
#include "engine/world/ties.hpp"

namespace pantin {

using namespace detail;

namespace {

/// The surface of one side in its body's mass-centre frame. Returns false if there is none.
bool place_side(const World& world, Entity body, const std::optional<Shape>& given,
                ContactSurface& to) {
  if (given) {
    const Pose* origin = world.origins.find(body);
    to.skin = skin_of(*given), to.pose = origin ? compose(*origin, given->local) : given->local;
    return to.skin != nullptr;
  }
  const Shapes* shapes = world.shapes.find(body);
  for (std::size_t i = 0; shapes && i < shapes->list.size(); ++i) {
    to.skin = skin_of(shapes->list[i]), to.pose = shapes->list[i].local;
    if (to.skin) return true;
  }
  return false;
}

NurbsCurve told(const nurbs::Curve& made) {
  NurbsCurve to;
  to.degree = made.knots.degree, to.knots = made.knots.values, to.periodic = made.knots.is_periodic;
  for (const nurbs::Weighted& w : made.points)
    to.points.push_back(w.point()), to.weights.push_back(w.w);
  return to;
}
Result<NurbsCurve> told(Result<nurbs::Curve> made) {
  if (!made) return Error{made.errors()[0]};
  return told(*made);
}

/// Sets the curve of one side; returns its fault, or an empty string.
std::string place_curve(const World& world, Entity body, const NurbsCurve& given,
                        ContactSurface& to) {
  nurbs::Curve curve{{given.degree, given.knots, given.periodic}, {}};
  if (!given.weights.empty() && given.weights.size() != given.points.size())
    return "found " + std::to_string(given.weights.size()) + " weights, expected one per point";
  for (std::size_t i = 0; i < given.points.size(); ++i)
    curve.points.emplace_back(given.points[i], given.weights.empty() ? 1 : given.weights[i]);
  if (const std::vector<Error> errors = nurbs::errors_of(curve, "the curve"); !errors.empty())
    return errors[0].message;
  to.curve = contact_curve(curve, given.inside_out ? OuterSide::left : OuterSide::right);
  const Pose* origin = world.origins.find(body);
  to.pose = origin ? compose(*origin, given.at) : given.at;
  return curve_fault(*to.curve);
}

}  // namespace

NurbsCurve NurbsCurve::line(Vec3 from, Vec3 to) { return told(nurbs::line(from, to)); }
NurbsCurve NurbsCurve::circle(Real radius) { return told(nurbs::circle({}, radius)); }
NurbsCurve NurbsCurve::ellipse(Real a, Real b) { return told(nurbs::ellipse({}, a, b)); }
Result<NurbsCurve> NurbsCurve::through(const std::vector<Vec3>& points) {
  return told(nurbs::interpolated(points, 3, nurbs::Ends::open));
}
Result<NurbsCurve> NurbsCurve::around(const std::vector<Vec3>& points) {
  return told(nurbs::interpolated(points, 3, nurbs::Ends::periodic));
}
Result<NurbsCurve> NurbsCurve::outline(const std::vector<Vec3>& corners, Real rounding) {
  return told(nurbs::rounded_polygon(corners, rounding));
}

Result<Entity> add_to(World& world, const SurfaceJoint& described) {
  Findings findings(world, "SurfaceJoint", described.name);
  findings.bodies(described.a, described.b);
  const bool are_curves = described.curve_a && described.curve_b;
  findings.known({{are_curves ? Feature::curve_contact : Feature::surface_contact}},
                 {described.a, described.b});
  if (!findings.ok()) return findings.take();
  SurfaceContact c;
  c.a = described.a, c.b = described.b;
  c.motion = described.motion, c.lifts = described.may_lift, c.on_rim = described.on_rim;
  constexpr const char* kSmooth = "a sphere, an ellipsoid, a cylinder, a plane or a NURBS shape";
  std::string why;
  if (described.curve_a)
    why = place_curve(world, c.a, *described.curve_a, c.on_a);
  else if (!place_side(world, c.a, described.surface_a, c.on_a))
    findings.add("surface_a", "no smooth shape", kSmooth);
  if (described.curve_b && why.empty())
    why = place_curve(world, c.b, *described.curve_b, c.on_b);
  else if (!described.curve_b && !place_side(world, c.b, described.surface_b, c.on_b))
    findings.add("surface_b", "no smooth shape", kSmooth);
  if (described.friction) findings.within("friction", *described.friction, 0, 1e3);
  if (described.friction && c.motion == SurfaceMotion::rolling_without_spin)
    findings.add("friction", "one of rolling without spin", "sliding or rolling");
  const int most = c.lifts ? static_cast<int>(kMostSpots) : 1;
  if (described.contacts && (*described.contacts < 1 || *described.contacts > most))
    findings.add("contacts", std::to_string(*described.contacts),
                 c.lifts ? "a whole number from 1 to 8" : "1 unless the contact is unilateral");
  if (!findings.ok()) return findings.take();
  c.friction = described.friction.value_or(-1);
  c.spots = described.contacts ? static_cast<std::uint8_t>(*described.contacts) : usual_spots(c);
  if (why.empty()) why = place_surfaces(c, {world.bodies[c.a].pose, world.bodies[c.b].pose});
  if (why.empty()) return add_surface_contact(world, c, described.name);
  return Error{"SurfaceJoint" + (described.name.empty() ? "" : " '" + described.name + "'") + ": " +
               why};
}

std::optional<SurfaceTouch> surface_touch(const World& world, Entity joint) {
  const SurfaceContact* c = world.surface_contacts.find(joint);
  if (!c) return std::nullopt;
  return SurfaceTouch{c->touches, c->slips, c->point, c->normal, c->force, c->gap};
}

std::vector<SurfaceTouch> surface_touches(const World& world, Entity joint) {
  const std::optional<SurfaceTouch> first = surface_touch(world, joint);
  if (!first) return {};
  std::vector<SurfaceTouch> all;
  if (first->normal != Vec3(0)) all.push_back(*first);
  for (const SurfaceSpot& s : world.surface_contacts[joint].more)
    if (s.normal != Vec3(0)) all.push_back({s.touches, s.slips, s.point, s.normal, s.force, s.gap});
  return all;
}

}  // namespace pantin
