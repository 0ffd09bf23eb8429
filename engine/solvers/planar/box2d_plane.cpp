// With box2d_contacts.hpp the only file that depends on Box2D 2.4.
#include "engine/solvers/planar/plane.hpp"

#ifdef PANTIN_HAS_BOX2D
#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "engine/solvers/planar/box2d_contacts.hpp"

namespace pantin::detail::planar {
namespace {

constexpr int kVelocityIterations = 8, kPositionIterations = 3;
constexpr int kFewestSubsteps = 4, kMostSubsteps = 64;
// Box2D clamps the motion of a step to 2 units and a quarter of a turn.
constexpr Real kMostUnits = 1.2, kMostTurn = 1.0;
// Box2D rests polygons one linear slop inside their radii, which are two slops wide. Outlines are
// offset inwards or outwards so that the given surfaces meet.
constexpr float kInset = 1.5f * b2_linearSlop, kDiscOutset = 0.5f * b2_linearSlop;
constexpr float kTiniest = 1e-20f, kFar = 1e3f;  // kFar: units
constexpr Real kHuge = 1e30;                     // of a drive: more is no number of Box2D
constexpr Real kCapped = 1 - 1e-3;               // of the maximum: single precision

/// Lengths in units, positions from a local origin.
struct Scale {
  Vec3 origin{0};
  Real per_metre = 1;

  float length(Real metres) const { return static_cast<float>(metres * per_metre); }
  b2Vec2 vector(Vec3 v) const { return {length(v.x), length(v.y)}; }
  b2Vec2 place(Vec3 p) const { return vector(p - origin); }
  float torque(Real t) const { return static_cast<float>(t * per_metre * per_metre); }
  Vec3 back(b2Vec2 v) const { return Vec3(v.x, v.y, 0) / per_metre; }
};

Scale scale_of(const Plane& plane) {
  Scale scale;
  scale.per_metre = 1 / plane.unit;
  Real count = 0;
  for (const PlaneBody& b : plane.bodies)
    if (b.kind == PlaneBody::dynamic) scale.origin += b.position, ++count;
  if (count > 0) scale.origin /= count;
  return scale;
}

/// The radius of a circle about the origin that contains all moving bodies with a margin, m.
Real reach_of(const Plane& plane, const Scale& scale) {
  Real reach = 0;
  for (const PlaneBody& b : plane.bodies)
    if (b.kind == PlaneBody::dynamic)
      reach = std::max(reach, glm::length(b.position - scale.origin));
  return reach + 20 * plane.unit;
}

/// Corners moved inwards by the inset; unchanged if the polygon is too thin for that.
int move_in(const b2Vec2* from, int count, b2Vec2* to) {
  for (int i = 0; i < count; ++i) {
    const b2Vec2 before = from[(i + count - 1) % count], at = from[i],
                 after = from[(i + 1) % count];
    b2Vec2 in = at - before, out = after - at;
    in.Normalize(), out.Normalize();
    const float turn = b2Cross(in, out);
    // Intersection of both edges after they moved to the left.
    const float along = turn > 1e-3f ? (1 - b2Dot(in, out)) / turn : 0;
    const b2Vec2 left(-out.y, out.x);
    to[i] = at + kInset * (left + along * out);
  }
  float twice = 0;
  for (int i = 0; i < count; ++i) twice += b2Cross(to[i], to[(i + 1) % count]);
  if (!(twice > 0)) std::copy(from, from + count, to);
  return count;
}

void add_polygon(b2Body& body, b2FixtureDef& how, const b2Vec2* corners, int count) {
  // Not by Set(), which starts at the rightmost corner: contact ids would change when another
  // corner becomes the rightmost.
  b2PolygonShape shape;
  shape.m_count = move_in(corners, count, shape.m_vertices);
  shape.m_centroid.SetZero();
  for (int i = 0; i < count; ++i) {
    const b2Vec2 side = shape.m_vertices[(i + 1) % count] - shape.m_vertices[i];
    shape.m_normals[i] = b2Cross(side, 1.0f);
    shape.m_normals[i].Normalize();
    shape.m_centroid += (1.0f / static_cast<float>(count)) * shape.m_vertices[i];
  }
  how.shape = &shape;
  body.CreateFixture(&how);  // copies the shape
  how.shape = nullptr;
}

/// A rotation about z by an angle of any size.
struct Turn {
  Real cosine, sine;
  explicit Turn(Real angle) : cosine(std::cos(angle)), sine(std::sin(angle)) {}
  Vec3 operator()(Vec3 v) const {
    return {cosine * v.x - sine * v.y, sine * v.x + cosine * v.y, 0};
  }
};

/// The body that outlines are made for, and its surface parameters.
struct Site {
  const Plane& plane;
  const Scale& scale;
  const PlaneBody& of;
  b2Body& body;
  b2FixtureDef how = {};
};

void add_half_plane(Site& site, const Outline& placed) {
  const Scale& scale = site.scale;
  b2Vec2 corners[4];
  const Real reach = reach_of(site.plane, scale);
  b2Body* on = &site.body;  // for a distant fixed body, one at the origin takes its corners
  const b2BodyDef here;
  if (site.of.kind == PlaneBody::fixed && on->GetPosition().Length() > kFar)
    on = on->GetWorld()->CreateBody(&here);
  const Vec3 n = placed.normal, along(n.y, -n.x, 0);
  const Vec3 middle = placed.centre + glm::dot(scale.origin - placed.centre, along) * along;
  const Vec3 deep = -2 * reach * n, at = scale.origin + scale.back(on->GetPosition());
  const Vec3 places[] = {middle - reach * along, middle - reach * along + deep,
                         middle + reach * along + deep, middle + reach * along};
  for (int i = 0; i < 4; ++i) corners[i] = scale.vector(places[i] - at);
  add_polygon(*on, site.how, corners, 4);
}

void add_outline(Site& site, const Outline& o) {
  const Turn turned(site.of.angle);
  if (o.kind == Outline::disc) {
    b2CircleShape shape;
    shape.m_p = site.scale.vector(turned(o.centre));
    shape.m_radius = site.scale.length(o.radius) + kDiscOutset;
    site.how.shape = &shape;
    site.body.CreateFixture(&site.how);
    site.how.shape = nullptr;
    return;
  }
  if (o.kind == Outline::half_plane) {
    Outline placed = o;
    placed.centre = site.of.position + turned(o.centre), placed.normal = turned(o.normal);
    return add_half_plane(site, placed);
  }
  b2Vec2 corners[b2_maxPolygonVertices];
  for (std::uint32_t i = 0; i < o.count; ++i)
    corners[i] = site.scale.vector(turned(site.plane.corners[o.first + i]));
  add_polygon(site.body, site.how, corners, static_cast<int>(o.count));
}

/// Data of a step: the b2World made for it, and its sources.
struct Stepper {
  Plane& plane;
  Scale scale;
  Real h = 0;  // s, of the whole step
  int substeps = kFewestSubsteps;
  b2World world;
  Real thinnest = 0;  // m, of the dynamic bodies
  std::vector<b2Body*> bodies = {};
  // By joint: the constraint, and the spring or motor of a hinge.
  std::vector<b2Joint*> holds = {}, springs = {};
  std::vector<Real> driven = {};  // impulses of drives, in Box2D's units
  float part() const { return static_cast<float>(h / substeps); }
};

int substeps_for(const Plane& plane, Real h) {
  Real most = 0;
  const Real gained = h * glm::length(plane.gravity);
  for (const PlaneBody& b : plane.bodies) {
    if (b.kind == PlaneBody::fixed || b.kind == PlaneBody::absent) continue;
    const Real way = (glm::length(b.velocity) + gained + h * glm::length(b.force) / b.mass) * h;
    const Real turn = (std::abs(b.spin) + h * std::abs(b.torque) / b.inertia) * h;
    most = std::max({most, way / (kMostUnits * plane.unit), turn / kMostTurn});
  }
  if (!(most < kMostSubsteps)) return kMostSubsteps;
  return std::max(kFewestSubsteps, static_cast<int>(std::ceil(most)));
}

/// m: half the width of the thinnest outline of a dynamic body.
Real thinnest_of(const Plane& plane) {
  Real least = 1e300;
  for (const PlaneBody& b : plane.bodies) {
    if (b.kind != PlaneBody::dynamic) continue;
    for (const Outline& o : std::span(plane.outlines).subspan(b.first, b.count)) {
      if (o.kind == Outline::disc) least = std::min(least, o.radius);
      if (o.kind != Outline::polygon) continue;
      const std::span<const Vec3> corners = std::span(plane.corners).subspan(o.first, o.count);
      const Vec3 middle =
          std::accumulate(corners.begin(), corners.end(), Vec3(0)) / Real(corners.size());
      for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec3 from = corners[i], along = corners[(i + 1) % corners.size()] - from;
        const Real length = glm::length(along);
        if (length > 0)
          least = std::min(least, std::abs(glm::cross(along, middle - from).z) / length);
      }
    }
  }
  return least;
}

void add_body(Stepper& s, std::uint32_t index) {
  const PlaneBody& b = s.plane.bodies[index];
  if (b.kind == PlaneBody::absent) return s.bodies.push_back(nullptr);
  b2BodyDef how;
  const bool dynamic = b.kind == PlaneBody::dynamic, fixed = b.kind == PlaneBody::fixed;
  how.type = dynamic ? b2_dynamicBody : fixed ? b2_staticBody : b2_kinematicBody;
  const Vec3 start = dynamic || fixed ? b.position : b.position - s.h * b.velocity;
  how.position = s.scale.place(start);
  if (!fixed) {
    how.linearVelocity = s.scale.vector(b.velocity);
    how.angularVelocity = static_cast<float>(b.spin);
  }
  if (!dynamic && !fixed) how.angle = static_cast<float>(-s.h * b.spin);
  how.gravityScale = static_cast<float>(b.gravity_scale);
  how.allowSleep = false;
  // Box2D sweeps two dynamic bodies against each other only if one of them is a bullet.
  how.bullet = dynamic && glm::length(b.velocity) * s.h > s.thinnest * s.substeps;
  b2Body& body = *s.world.CreateBody(&how);
  s.bodies.push_back(&body);
  Site site{s.plane, s.scale, b, body};
  site.how.density = 0;
  site.how.friction = static_cast<float>(b.friction);
  site.how.restitution = static_cast<float>(b.restitution);
  site.how.restitutionThreshold =
      s.scale.length(2 * glm::length(s.plane.gravity) * s.h / s.substeps) + 1e-3f;
  for (std::uint32_t i = 0; i < b.count; ++i) {
    site.how.userData.pointer = packed({index, i});
    add_outline(site, s.plane.outlines[b.first + i]);
  }
  if (!dynamic) return;
  const b2MassData mass{static_cast<float>(b.mass), b2Vec2(0, 0), s.scale.torque(b.inertia)};
  body.SetMassData(&mass);
  body.ApplyForceToCenter(s.scale.vector(b.force), true);
  body.ApplyTorque(s.scale.torque(b.torque), true);
}

template <class Definition>
Definition between(Stepper& s, const PlaneJoint& j) {
  Definition d;
  d.bodyA = s.bodies[j.a], d.bodyB = s.bodies[j.b], d.collideConnected = true;  // see may_touch()
  d.localAnchorA = s.scale.vector(j.arm_a), d.localAnchorB = s.scale.vector(j.arm_b);
  return d;
}

/// A spring or motor along the angle of a hinge: a weld with a soft angle. Its reference angle
/// represents the load, and compensates the warm start.
b2Joint* add_torsion(Stepper& s, const PlaneJoint& j) {
  const PlaneSpring& spring = j.along;
  if (!(spring.stiffness > 0) && !(spring.damping > 0)) {
    s.bodies[j.b]->ApplyTorque(s.scale.torque(spring.load), true);
    s.bodies[j.a]->ApplyTorque(-s.scale.torque(spring.load), true);
    return nullptr;
  }
  auto d = between<b2WeldJointDef>(s, j);
  d.stiffness = std::max(kTiniest, s.scale.torque(spring.stiffness));
  d.damping = s.scale.torque(spring.damping);
  d.referenceAngle = s.scale.torque(spring.load - j.load.spring) / d.stiffness;
  return s.world.CreateJoint(&d);
}

/// Of a drive: what single precision holds.
float within_huge(Real x) { return static_cast<float>(std::clamp(x, -kHuge, kHuge)); }

void add_hinge(Stepper& s, const PlaneJoint& j) {
  auto d = between<b2RevoluteJointDef>(s, j);
  d.enableLimit = j.limited;
  d.lowerAngle = static_cast<float>(j.low), d.upperAngle = static_cast<float>(j.high);
  d.enableMotor = j.drive.on, d.motorSpeed = within_huge(j.drive.rate);
  const Real per_metre = s.scale.per_metre;
  d.maxMotorTorque = within_huge(j.drive.most * per_metre * per_metre);
  s.holds.back() = s.world.CreateJoint(&d);
  s.springs.back() = add_torsion(s, j);
}

void add_weld(Stepper& s, const PlaneJoint& j) {
  auto d = between<b2WeldJointDef>(s, j);
  d.referenceAngle = static_cast<float>(-j.angle_error);
  s.holds.back() = s.world.CreateJoint(&d);
}

void add_slider(Stepper& s, const PlaneJoint& j) {
  auto d = between<b2PrismaticJointDef>(s, j);
  d.localAxisA = b2Vec2(static_cast<float>(j.axis.x), static_cast<float>(j.axis.y));
  d.referenceAngle = static_cast<float>(-j.angle_error);
  d.enableLimit = j.limited;
  d.lowerTranslation = s.scale.length(j.low), d.upperTranslation = s.scale.length(j.high);
  d.enableMotor = j.drive.on, d.motorSpeed = within_huge(j.drive.rate * s.scale.per_metre);
  d.maxMotorForce = within_huge(j.drive.most * s.scale.per_metre);
  s.holds.back() = s.world.CreateJoint(&d);
  const PlaneSpring& spring = j.along;
  if (spring.stiffness > 0 || spring.damping > 0) {
    auto w = between<b2WheelJointDef>(s, j);
    w.localAxisA = d.localAxisA;
    if (spring.stiffness > 0)  // rest position under the load
      w.localAnchorA += s.scale.length(spring.load / spring.stiffness) * w.localAxisA;
    w.stiffness = std::max(kTiniest, static_cast<float>(spring.stiffness));
    w.damping = static_cast<float>(spring.damping);
    s.world.CreateJoint(&w);
  }
  if (spring.load == 0 || spring.stiffness > 0) return;
  const b2Vec2 force = s.scale.length(spring.load) * d.localAxisA;
  const b2Vec2 at = s.bodies[j.b]->GetWorldPoint(d.localAnchorB);
  s.bodies[j.b]->ApplyForce(force, at, true), s.bodies[j.a]->ApplyForce(-force, at, true);
}

void add_rod(Stepper& s, const PlaneJoint& j) {
  auto d = between<b2DistanceJointDef>(s, j);
  d.length = d.minLength = d.maxLength = s.scale.length(j.length);
  if (j.kind == PlaneJoint::spring) {
    d.minLength = 0, d.maxLength = b2_maxFloat;
    d.stiffness = std::max(kTiniest, static_cast<float>(j.along.stiffness));
    d.damping = static_cast<float>(j.along.damping);
  }
  b2Joint* joint = s.world.CreateJoint(&d);
  if (j.kind == PlaneJoint::rod) s.holds.back() = joint;
}

void add_joint(Stepper& s, const PlaneJoint& j) {
  s.holds.push_back(nullptr), s.springs.push_back(nullptr);
  if (!s.bodies[j.a] || !s.bodies[j.b]) return;
  switch (j.kind) {
    case PlaneJoint::hinge:
      return add_hinge(s, j);
    case PlaneJoint::weld:
      return add_weld(s, j);
    case PlaneJoint::slider:
      return add_slider(s, j);
    default:  // rod, spring
      return add_rod(s, j);
  }
}

/// The part of a force that a joint can transmit in its present pose: the solver could not correct
/// the rest.
Vec3 borne(const Stepper& s, std::size_t joint, Vec3 force) {
  const PlaneJoint& j = s.plane.joints[joint];
  if (j.kind == PlaneJoint::slider) {
    const Vec3 axis = Turn(s.bodies[j.a]->GetAngle())(j.axis);
    return force - glm::dot(force, axis) * axis;
  }
  if (j.kind != PlaneJoint::rod) return force;
  const b2Vec2 span = s.holds[joint]->GetAnchorB() - s.holds[joint]->GetAnchorA();
  const Vec3 along(span.x, span.y, 0);
  return glm::dot(force, along) / glm::dot(along, along) * along;
}

/// Warm start: applies the loads of the last step to the bodies before a substep.
void begin_joints(Stepper& s) {
  for (std::size_t i = 0; i < s.holds.size(); ++i) {
    const PlaneJoint& j = s.plane.joints[i];
    if (!s.holds[i]) continue;
    b2Body &a = *s.bodies[j.a], &b = *s.bodies[j.b];
    const b2Vec2 force = s.part() * s.scale.vector(borne(s, i, j.load.force));
    const float torque = s.part() * s.scale.torque(j.load.torque + j.load.spring);
    // A slider's reaction acts on the rail at the slider.
    const b2Vec2 at = s.holds[i]->GetAnchorB();
    const b2Vec2 on_a = j.kind == PlaneJoint::slider ? at : s.holds[i]->GetAnchorA();
    a.ApplyLinearImpulse(-force, on_a, true), b.ApplyLinearImpulse(force, at, true);
    a.ApplyAngularImpulse(-torque, true), b.ApplyAngularImpulse(torque, true);
  }
}

void read_loads(Stepper& s) {
  const float per_step = 1 / s.part();
  const Real torque = 1 / (s.scale.per_metre * s.scale.per_metre);
  for (std::size_t i = 0; i < s.holds.size(); ++i) {
    PlaneJoint& j = s.plane.joints[i];
    if (!s.holds[i]) continue;
    const Vec3 more = s.scale.back(s.holds[i]->GetReactionForce(per_step));
    j.load.force = borne(s, i, j.load.force + more);
    if (j.kind == PlaneJoint::weld || j.kind == PlaneJoint::slider)
      j.load.torque += torque * s.holds[i]->GetReactionTorque(per_step);
    if (!s.springs[i]) continue;
    j.load.force += s.scale.back(s.springs[i]->GetReactionForce(per_step));
    j.load.spring += torque * s.springs[i]->GetReactionTorque(per_step);
  }
}

/// Adds the impulses of drives in a substep.
void add_drives(Stepper& s) {
  for (std::size_t i = 0; i < s.holds.size(); ++i) {
    const PlaneJoint& j = s.plane.joints[i];
    if (!j.drive.on || !s.holds[i]) continue;
    s.driven[i] += j.kind == PlaneJoint::hinge
                       ? static_cast<b2RevoluteJoint*>(s.holds[i])->GetMotorTorque(1)
                       : static_cast<b2PrismaticJoint*>(s.holds[i])->GetMotorForce(1);
  }
}

void read_drives(Stepper& s) {
  for (std::size_t i = 0; i < s.holds.size(); ++i) {
    PlaneJoint& j = s.plane.joints[i];
    if (!j.drive.on || !s.holds[i]) continue;
    const Real scale = s.scale.per_metre * (j.kind == PlaneJoint::hinge ? s.scale.per_metre : 1);
    j.drive.force = s.driven[i] / (s.h * scale);
    j.drive.capped = std::abs(j.drive.force) >= kCapped * j.drive.most;
  }
}

void read_results(Stepper& s) {
  for (std::size_t i = 0; i < s.bodies.size(); ++i) {
    PlaneBody& b = s.plane.bodies[i];
    if (b.kind != PlaneBody::dynamic) continue;
    const b2Body& body = *s.bodies[i];
    b.moved = s.scale.back(body.GetWorldCenter() - s.scale.place(b.position));
    b.sped_up = s.scale.back(body.GetLinearVelocity() - s.scale.vector(b.velocity));
    b.turned = body.GetAngle();
    b.spun_up = body.GetAngularVelocity() - static_cast<float>(b.spin);
  }
}

void read_touches(Stepper& s, std::vector<PlaneContact>& touches) {
  touches.clear();
  for (b2Contact* c = s.world.GetContactList(); c; c = c->GetNext()) {
    const b2Manifold& m = *c->GetManifold();
    if (!c->IsTouching() || !c->IsEnabled()) continue;
    b2WorldManifold at;
    c->GetWorldManifold(&at);
    for (int i = 0; i < m.pointCount; ++i) {
      PlaneContact t = touch_of(*c, m.points[i]);
      t.normal_impulse = m.points[i].normalImpulse / static_cast<float>(s.scale.per_metre);
      t.tangent_impulse = m.points[i].tangentImpulse / static_cast<float>(s.scale.per_metre);
      t.point = s.scale.origin + s.scale.back(at.points[i]);
      t.normal = Vec3(-at.normal.x, -at.normal.y, 0);
      t.depth = std::max(0.0, -Real(at.separations[i] + b2_linearSlop) / s.scale.per_metre);
      touches.push_back(t);
    }
  }
  std::sort(touches.begin(), touches.end(), comes_before);
}

/// Adds the impulses of the step, and the contacts that ended in it.
void add_impulses(const Stepper& s, const std::vector<PlaneContact>& borne,
                  std::vector<PlaneContact>& touches) {
  const auto lasting = static_cast<std::ptrdiff_t>(touches.size());
  for (const PlaneContact& b : borne) {
    const auto end = touches.begin() + lasting;
    const auto at = std::lower_bound(touches.begin(), end, b, comes_before);
    const bool lasts = at != end && !comes_before(b, *at);
    if (lasts) at->impulse += b.impulse;
    if (lasts || b.impulse == Vec3(0)) continue;
    touches.push_back(b), touches.back().ended = true;
    touches.back().point = s.scale.origin + b.point / s.scale.per_metre;
  }
  std::sort(touches.begin(), touches.end(), comes_before);
}

}  // namespace

void step_plane(Plane& plane, Real h, std::vector<PlaneContact>& touches) {
  const Scale scale = scale_of(plane);
  Stepper s{plane, scale, h, substeps_for(plane, h), b2World(scale.vector(plane.gravity))};
  Filter filter(plane);
  ContactListener warm(plane, touches, scale.origin, scale.per_metre);
  s.world.SetContactFilter(&filter), s.world.SetContactListener(&warm);
  s.world.SetAllowSleeping(false), s.world.SetAutoClearForces(false);
  // Box2D scales warm-start impulses by the ratio of two steps, and drops them in a first step.
  s.world.Step(s.part(), 0, 0);
  s.bodies.reserve(plane.bodies.size()), s.thinnest = thinnest_of(plane);
  for (std::uint32_t i = 0; i < plane.bodies.size(); ++i) add_body(s, i);
  for (const PlaneJoint& j : plane.joints) add_joint(s, j);
  s.driven.assign(s.holds.size(), 0);
  for (int i = 0; i < s.substeps; ++i) {
    begin_joints(s);
    s.world.Step(s.part(), kVelocityIterations, kPositionIterations);
    add_drives(s), warm.end();
  }
  read_results(s), read_loads(s), read_drives(s), read_touches(s, touches);
  add_impulses(s, warm.borne(), touches);
}

}  // namespace pantin::detail::planar

#else

namespace pantin::detail::planar {
void step_plane(Plane&, Real, std::vector<PlaneContact>&) {}
}  // namespace pantin::detail::planar

#endif
