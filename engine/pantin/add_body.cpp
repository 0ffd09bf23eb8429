#include <algorithm>
#include <cmath>
#include <limits>
#include <pantin/shapes.hpp>

#include "engine/base/rotation.hpp"
#include "engine/geometry/mass_properties.hpp"
#include "engine/geometry/skin_model.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/pantin/detail/checks.hpp"
#include "engine/pantin/detail/touching.hpp"
#include "engine/runtime/requests.hpp"

namespace pantin {

using namespace detail;

namespace {

using Surfaces = Result<std::shared_ptr<const Surface>>;

nurbs::Surface surface_of(const NurbsShape::Face& f) {
  nurbs::Surface s{
      {f.degree_u, f.knots_u, f.periodic_u}, {f.degree_v, f.knots_v, f.periodic_v}, {}};
  const bool is_weighted = f.weights.size() == f.points.size();
  for (std::size_t i = 0; i < f.points.size(); ++i)
    s.points.emplace_back(f.points[i], is_weighted ? f.weights[i] : 1);
  return s;
}

/// Converts the shapes of a description, and checks each.
struct ShapeMaker {
  Findings& findings;
  Motion motion;
  Shape shape = {};
  bool made = true;

  void stage(const Pose& at) {
    findings.finite("shape.at", at);
    shape.local = {at.position, findings.rotation("shape.at", at.rotation)};
  }
  void need_still(const char* what) {
    if (motion == Motion::dynamic)
      findings.add("shape", std::string("a ") + what + " on a dynamic body",
                   "a sphere, a capsule, a cylinder, a cone, an ellipsoid, a box or a hull");
  }
  void take(ShapeKind kind, const Surfaces& surface) {
    shape.kind = kind;
    if (surface) {
      shape.surface = *surface;
      return;
    }
    for (const Error& e : surface.errors()) findings.add("shape", e.message, "a valid surface");
  }

  void operator()(std::monostate) { made = false; }
  void operator()(const SphereShape& s) {
    findings.above_zero("shape.radius", s.radius);
    shape.kind = ShapeKind::sphere, shape.size = {s.radius, 0, 0};
    stage(s.at);
  }
  void operator()(const CapsuleShape& s) {
    findings.above_zero("shape.radius", s.radius);
    findings.not_negative("shape.half_length", s.half_length);
    shape.kind = ShapeKind::capsule, shape.size = {s.radius, s.half_length, 0};
    stage(s.at);
  }
  void operator()(const BoxShape& s) {
    for (int i = 0; i < 3; ++i) findings.above_zero("shape.half_extents", s.half_extents[i]);
    shape.kind = ShapeKind::box, shape.size = s.half_extents;
    stage(s.at);
  }
  void operator()(const CylinderShape& s) {
    findings.above_zero("shape.radius", s.radius);
    findings.above_zero("shape.half_length", s.half_length);
    shape.kind = ShapeKind::cylinder, shape.size = {s.radius, s.half_length, 0};
    stage(s.at);
  }
  void operator()(const ConeShape& s) {
    findings.above_zero("shape.radius", s.radius);
    findings.above_zero("shape.half_height", s.half_height);
    shape.kind = ShapeKind::cone, shape.size = {s.radius, s.half_height, 0};
    stage(s.at);
  }
  void operator()(const EllipsoidShape& s) {
    for (int i = 0; i < 3; ++i) findings.above_zero("shape.radii", s.radii[i]);
    shape.kind = ShapeKind::ellipsoid, shape.size = s.radii;
    stage(s.at);
  }
  void operator()(const NurbsShape& s) {
    findings.within("shape.tolerance", s.tolerance, 0, 1);
    if (s.faces.empty()) findings.add("shape.faces", "none", "at least one face");
    std::vector<nurbs::Surface> faces;
    bool sound = !s.faces.empty();
    for (std::size_t i = 0; i < s.faces.size(); ++i) {
      nurbs::Surface face = surface_of(s.faces[i]);
      const std::string name = "face " + std::to_string(i);
      if (s.faces[i].weights.size() > 0 && s.faces[i].weights.size() != s.faces[i].points.size()) {
        findings.add("shape.faces",
                     name + ", " + std::to_string(s.faces[i].weights.size()) + " weights",
                     "one for each point, or none");
        sound = false;
      }
      for (const Error& e : nurbs::errors_of(face, name))
        findings.add("shape.faces", e.message, "a valid face"), sound = false;
      faces.push_back(std::move(face));
    }
    if (sound && findings.ok())
      take(ShapeKind::nurbs,
           make_skin(std::make_shared<nurbs::Skin>(std::move(faces), s.tolerance)));
    stage(s.at);
  }
  void operator()(const HullShape& s) {
    take(ShapeKind::hull, make_hull(s.points));
    stage(s.at);
  }
  void operator()(const PlaneShape& s) {
    need_still("plane");
    findings.above_zero("shape.drawn_extent", s.drawn_extent);
    shape.kind = ShapeKind::plane, shape.size = {s.drawn_extent, 0, 0};
    stage(s.at);
  }
  void operator()(const MeshShape& s) {
    need_still("mesh");
    take(ShapeKind::mesh, make_mesh(s.points, s.triangles));
    stage(s.at);
  }
  void operator()(const HeightFieldShape& s) {
    need_still("height field");
    if (std::uint64_t(s.columns) * s.rows != s.heights.size())
      findings.add("shape.heights", std::to_string(s.heights.size()) + " numbers",
                   "columns times rows of them");
    else
      take(ShapeKind::height_field,
           make_height_field({s.columns, s.rows, s.spacing_x, s.spacing_z, s.heights}));
    stage(s.at);
  }
};

std::vector<Shape> shapes_of(const RigidBody& body, Findings& findings) {
  std::vector<Shape> shapes;
  const auto add = [&](const BodyShape& described) {
    ShapeMaker maker{findings, body.motion};
    maker.shape.material = body.material;
    std::visit(maker, described);
    if (maker.made) shapes.push_back(std::move(maker.shape));
  };
  add(body.shape);
  for (const BodyShape& s : body.shapes) add(s);
  return shapes;
}

MassProperties weigh(const RigidBody& body, const std::vector<Shape>& shapes, Findings& findings) {
  MassProperties whole;
  for (const Shape& s : shapes) whole = combine(whole, mass_properties(s, body.density));
  if (body.mass) {
    if (whole.mass > 0) whole.inertia *= *body.mass / whole.mass;
    whole.mass = *body.mass;
  }
  if (body.inertia) whole.inertia = *body.inertia;
  if (!findings.ok()) return whole;
  if (shapes.empty() && !body.mass) {
    findings.add("shape", "none, and no mass", "a shape, or mass and inertia");
  } else if (shapes.empty() && !body.inertia) {
    findings.add("inertia", "none, and no shape", "an inertia, or a shape that determines it");
  } else if (const Vec3 moments = principal_inertia(whole.inertia).moments;
             !(whole.mass > 0) || !std::isfinite(whole.mass) || !is_finite(moments) ||
             !is_possible_inertia(moments)) {
    findings.add("mass and inertia", shown(whole.mass) + " kg, " + shown(moments) + " kg m^2",
                 "a finite mass above 0 and three moments, each at most the sum of the others");
  }
  return whole;
}

void check(const RigidBody& body, Findings& findings) {
  findings.above_zero("density", body.density);
  if (body.mass) findings.above_zero("mass", *body.mass);
  if (body.inertia)
    for (int i = 0; i < 3; ++i) findings.finite("inertia", (*body.inertia)[i]);
  findings.finite("position", body.position);
  findings.finite("velocity", body.velocity);
  findings.finite("angular_velocity", body.angular_velocity);
  findings.not_negative("drag", body.drag);
  findings.finite("gravity_scale", body.gravity_scale);
  if (body.material >= findings.world().materials.size())
    findings.add("material", std::to_string(body.material), "an index into World::materials");
  if (body.collision) check(findings, *body.collision);
}

void check(const MaterialPair& pair, Findings& findings) {
  const std::size_t count = findings.world().materials.size();
  for (const auto& [member, index] : {std::pair{"a", pair.a}, std::pair{"b", pair.b}})
    if (index >= count)
      findings.add(member, std::to_string(index), "an index into World::materials");
  for (const MaterialPair& known : findings.world().material_pairs)
    if (std::minmax(known.a, known.b) == std::minmax(pair.a, pair.b))
      findings.add("a and b", "two materials that already form a pair", "another pair");
  if (pair.friction) findings.not_negative("friction", *pair.friction);
  if (pair.restitution) findings.within("restitution", *pair.restitution, 0, 1);
  if (pair.rolling) findings.not_negative("rolling", *pair.rolling);
  if (pair.spinning) findings.not_negative("spinning", *pair.spinning);
}

/// Wakes bodies that touch with shapes of the two materials: they may slide now.
void wake_touching(World& world, const MaterialPair& pair) {
  const auto has = [&](Entity body, std::uint32_t material) {
    const Shapes* shapes = world.shapes.find(body);
    return shapes && std::any_of(shapes->list.begin(), shapes->list.end(),
                                 [&](const Shape& s) { return s.material == material; });
  };
  each_touching(world, [&](Entity a, Entity b) {
    if ((has(a, pair.a) && has(b, pair.b)) || (has(a, pair.b) && has(b, pair.a)))
      rouse(world, a), rouse(world, b);
  });
}

}  // namespace

Result<std::uint32_t> add_to(World& world, const MaterialPair& pair) {
  Findings findings(world, "MaterialPair", {});
  check(pair, findings);
  if (!findings.ok()) return findings.take();
  world.material_pairs.push_back(pair);
  wake_touching(world, pair);
  return static_cast<std::uint32_t>(world.material_pairs.size() - 1);
}

Result<Entity> add_to(World& world, const RigidBody& described) {
  Findings findings(world, "RigidBody", described.name);
  check(described, findings);
  const Pose frame{described.position, findings.rotation("rotation", described.rotation)};
  std::vector<Shape> shapes = shapes_of(described, findings);
  Body body;
  Pose centre;  // the mass-centre frame in the body's own
  if (described.motion == Motion::dynamic) {
    MassProperties whole = weigh(described, shapes, findings);
    if (!findings.ok()) return findings.take();
    round_off(whole);
    const PrincipalInertia principal = principal_inertia(whole.inertia);
    body.mass = whole.mass, body.inertia = principal.moments;
    centre = {whole.centre, principal.rotation};
  }
  if (!findings.ok()) return findings.take();

  const bool moved = centre.position != Vec3(0) || centre.rotation != kIdentity;
  if (moved)
    for (Shape& s : shapes) s.local = compose(inverse(centre), s.local);
  body.motion = described.motion;
  body.pose = moved ? compose(frame, centre) : frame;
  body.velocity = described.velocity, body.angular_velocity = described.angular_velocity;
  body.drag = described.drag, body.gravity_scale = described.gravity_scale;
  const Entity e = world.add_body(body, described.name);
  if (moved) world.origins.add(e, inverse(centre));
  if (!shapes.empty()) world.shapes.add(e, {std::move(shapes)});
  if (described.collision) world.collisions.add(e, *described.collision);
  return e;
}

}  // namespace pantin
