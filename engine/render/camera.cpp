#include <algorithm>
#include <limits>
#include <numeric>

#include "engine/base/rotation.hpp"
#include "engine/geometry/skin_model.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/nurbs/closest.hpp"
#include "engine/render/belts.hpp"
#include "engine/render/bounds.hpp"
#include "engine/render/eye.hpp"
#include "engine/render/renderer.hpp"
#include "engine/render/supports.hpp"

namespace pantin::detail {
namespace {

constexpr Real kFar = std::numeric_limits<Real>::infinity();

/// A box of displacements.
struct Sway {
  Vec3 low{0}, high{0};
  void take(Vec3 d) { low = glm::min(low, d), high = glm::max(high, d); }
  void take_all(const Sway& other) { take(other.low), take(other.high); }
};

/// Where a path may take its body, relative to the body's present position.
Sway sway_of(const KinematicPath& drive, Vec3 now) {
  Sway sway;
  const PathBounds bounds = bounds_of(drive);
  if (glm::all(glm::lessThanEqual(bounds.low, bounds.high)))
    sway.take(bounds.low - now), sway.take(bounds.high - now);
  return sway;
}

/// A group of connected bodies, the points that hold it, and its displacements.
struct Hanging {
  std::vector<Vec3> holds;  // distinct points that hold it
  Sway sway;
};

/// Groups of dynamic bodies connected by links and cables; other bodies are groups of their own.
class Groups {
 public:
  explicit Groups(const World& world) : world_(world), up_(world.bodies.size()) {
    std::iota(up_.begin(), up_.end(), 0u);
    of_.resize(up_.size());
    for_each_tie([this](const End& a, const End& b) { join(a.slot, b.slot); });
    for_each_tie([this](const End& a, const End& b) { note_holder(a, b); });
    for (const Pin& pin : world.pins.values())
      if (const std::uint32_t slot = world.bodies.slot(pin.body); slot != kNoSlot && !pin.to)
        hold(top(slot), pin.target, Sway{});
    for (std::uint32_t slot = 0; slot < up_.size(); ++slot) of_[top(slot)].sway.take_all(own(slot));
  }

  const Hanging& of(std::uint32_t slot) { return of_[top(slot)]; }

 private:
  std::uint32_t top(std::uint32_t slot) {
    while (up_[slot] != slot) slot = up_[slot] = up_[up_[slot]];
    return slot;
  }

  /// One end of a link, a cable or a pin.
  struct End {
    std::uint32_t slot;
    Vec3 anchor;  // in the body
  };

  /// Calls `visit` with both ends of each link, cable and pin between two bodies.
  void for_each_tie(auto&& visit) const {
    const auto tie = [&](Entity a, Vec3 on_a, Entity b, Vec3 on_b) {
      const End ends[2] = {{world_.bodies.slot(a), on_a}, {world_.bodies.slot(b), on_b}};
      if (ends[0].slot != kNoSlot && ends[1].slot != kNoSlot) visit(ends[0], ends[1]);
    };
    for (const Link& l : world_.links.values()) tie(l.a, l.joint.anchor_a, l.b, l.joint.anchor_b);
    for (const Cable& c : world_.cables.values()) tie(c.a, c.joint.anchor_a, c.b, c.joint.anchor_b);
    for (const Pin& pin : world_.pins.values()) tie(pin.body, pin.anchor, pin.to, pin.target);
  }

  /// Joins the groups of two dynamic bodies.
  void join(std::uint32_t i, std::uint32_t j) {
    if (is_dynamic(i) && is_dynamic(j)) up_[top(i)] = top(j);
  }

  /// If one of two bodies is dynamic, the other one holds its group at the point of its end.
  void note_holder(const End& a, const End& b) {
    const bool free_a = is_dynamic(a.slot), free_b = is_dynamic(b.slot);
    if (free_a == free_b) return;
    const End &holder = free_a ? b : a, &held = free_a ? a : b;
    hold(top(held.slot), to_world(world_.bodies.values()[holder.slot].pose, holder.anchor),
         own(holder.slot));
  }

  void hold(std::uint32_t group, Vec3 position, const Sway& sway) {
    Hanging& hanging = of_[group];
    hanging.sway.take_all(sway);
    for (Vec3 known : hanging.holds)
      if (known == position) return;
    hanging.holds.push_back(position);
  }

  bool is_dynamic(std::uint32_t slot) const {
    return world_.bodies.values()[slot].motion == Motion::dynamic;
  }

  /// The displacements by a body's own path.
  Sway own(std::uint32_t slot) const {
    const KinematicPath* drive = world_.paths.find(world_.bodies.owners()[slot]);
    const Sway sway = drive ? sway_of(*drive, world_.bodies.values()[slot].pose.position) : Sway{};
    return is_finite(sway.low) && is_finite(sway.high) ? sway : Sway{};
  }

  const World& world_;
  std::vector<std::uint32_t> up_;  // a body of the same group; the root of a group is its own
  std::vector<Hanging> of_;        // by the root of the group
};

/// The possible displacements of a body.
struct Carried {
  const Hanging& hanging;  // its group
  Vec3 centre;             // of the body, world, m
  Vec3 down;               // unit, world
};

/// The ball at present, at the opposite end and the lowest point of a swing, and displaced by
/// paths.
void add_motion(const Ball& now, const Carried& body, std::vector<Ball>& to) {
  const auto& [hanging, centre, down] = body;
  std::vector<Ball> swung{now};
  if (hanging.holds.size() == 1) {  // held at one point, it may swing like a pendulum
    const Vec3 arm = centre - hanging.holds.front();
    const Vec3 aside = arm - glm::dot(arm, down) * down;
    if (glm::length(aside) > 0.2 * glm::length(arm)) {
      swung.push_back({now.centre - 2.0 * aside, now.radius});
      swung.push_back({now.centre - arm + glm::length(arm) * down, now.radius});
    }
  }
  const Sway& sway = hanging.sway;
  const int corners = sway.low == sway.high ? 1 : 8;
  for (const Ball& ball : swung)
    for (int c = 0; c < corners; ++c)
      to.push_back(
          {ball.centre + Vec3{c & 1 ? sway.high.x : sway.low.x, c & 2 ? sway.high.y : sway.low.y,
                              c & 4 ? sway.high.z : sway.low.z},
           ball.radius});
}

/// Adds the balls of bodies that a motor turns about an axis of a body that is not dynamic, along
/// their circles.
void add_cranks(const World& world, std::vector<Ball>& to) {
  constexpr int kAround = 8;
  std::vector<Ball> own;
  const auto bodies = world.bodies.values();
  for (const Link& link : world.links.values()) {
    const std::uint32_t a = world.bodies.slot(link.a), b = world.bodies.slot(link.b);
    const bool is_driven = link.joint.kind == JointKind::hinge &&
                           link.joint.parameters->rotation.motor.kind != MotorKind::none;
    if (!is_driven || a == kNoSlot || b == kNoSlot || !is_finite(bodies[b].pose)) continue;
    if (bodies[a].motion == Motion::dynamic || !is_finite(bodies[a].pose)) continue;
    const Vec3 at = to_world(bodies[a].pose, link.joint.anchor_a),
               axis = bodies[a].pose.rotation * (link.joint.frames.a() * Vec3(1, 0, 0));
    own.clear();
    if (const Shapes* shapes = world.shapes.find(link.b))
      for (const Shape& shape : shapes->list) add_balls(shape, bodies[b].pose, own);
    for (const Ball& ball : own)
      for (int i = 1; i < kAround; ++i)
        to.push_back({at + from_rotation_vector(2 * kPi * i / kAround * axis) * (ball.centre - at),
                      ball.radius});
  }
}

/// Adds what is drawn of curves in contact: their points in the plane.
void add_curves(const World& world, const SurfaceContact& contact, std::vector<Ball>& to) {
  for (const auto& [body, on] : {std::pair{contact.a, &contact.on_a}, {contact.b, &contact.on_b}}) {
    const Body* b = world.bodies.find(body);
    if (!b || !on->curve || !is_finite(b->pose)) continue;
    const Pose at = compose(b->pose, on->pose);
    for (const nurbs::Weighted& p : on->curve->curve().points)
      to.push_back({to_world(at, p.point()), 0});
  }
}

struct Ground {
  const Shape* shape;
  Pose pose;
};

/// Adds height fields near the other objects; whole grounds if there are no other objects.
void add_grounds(std::span<const Ground> grounds, std::vector<Ball>& balls) {
  if (balls.empty()) {
    for (const Ground& ground : grounds) add_balls(*ground.shape, ground.pose, balls);
    return;
  }
  Vec3 low{kFar}, high{-kFar};
  for (const Ball& b : balls)
    low = glm::min(low, b.centre - b.radius), high = glm::max(high, b.centre + b.radius);
  const Real margin = 0.3 * std::max({high.x - low.x, high.y - low.y, high.z - low.z});
  for (const Ground& ground : grounds) {
    const ShapeClass of = traits_of(ground.shape->kind).shape_class;
    if (of != ShapeClass::heights || !ground.shape->surface) continue;
    const Pose at = compose(ground.pose, ground.shape->local);
    for (Vec3 point : ground.shape->surface->points) {
      const Vec3 p = to_world(at, point);
      const bool near = p.x > low.x - margin && p.x < high.x + margin && p.z > low.z - margin &&
                        p.z < high.z + margin;
      if (near) balls.push_back({p, 0});
    }
  }
}

std::vector<Ball> all_balls(const World& world) {
  Groups groups(world);
  const Vec3 down = down_of(world);
  std::vector<Ball> balls, own;
  std::vector<Ground> grounds;
  const auto bodies = world.bodies.values();
  for (std::uint32_t slot = 0; slot < bodies.size(); ++slot) {
    const Pose& pose = bodies[slot].pose;
    if (!is_finite(pose)) continue;
    own.clear();
    const std::size_t known = grounds.size();
    if (const Shapes* shapes = world.shapes.find(world.bodies.owners()[slot])) {
      for (const Shape& shape : shapes->list) {
        if (is_ground(shape.kind)) grounds.push_back({&shape, pose});
        if (!is_ground(shape.kind)) add_balls(shape, pose, own);
      }
    }
    if (own.empty() && grounds.size() == known) own.push_back({pose.position, 0});
    for (const Ball& ball : own) add_motion(ball, {groups.of(slot), pose.position, down}, balls);
  }
  for (const SurfaceContact& c : world.surface_contacts.values()) add_curves(world, c, balls);
  add_cranks(world, balls);
  std::vector<SupportPart> supports;
  add_supports({world}, supports);
  for (const SupportPart& part : supports) add_balls(part.shape, part.pose, balls);
  std::vector<BeltPiece> pieces;
  for (const Belt& belt : world.belts.values()) add_belt({world}, belt, pieces);
  for (const BeltPiece& piece : pieces) add_balls(piece.box, piece.pose, balls);
  std::vector<Vec3> curve;
  for (const Cable& cable : world.cables.values()) add_cable({world}, cable, 8, curve);
  for (Vec3 point : curve) balls.push_back({point, 0});
  add_grounds(grounds, balls);
  return balls;
}

/// If the ground is near, adds the projections of the balls on it, straight down and along the
/// shadow. Balls below it are moved up to it, because they are hidden.
void add_ground(const View& view, std::vector<Ball>& balls) {
  Real low = kFar, high = -kFar;
  for (const Ball& b : balls) {
    low = std::min(low, b.centre.y - b.radius);
    high = std::max(high, b.centre.y + b.radius);
  }
  const Real ground = view.ground_height;
  if (!view.ground || high < ground || low - ground > 0.75 * (high - low)) return;
  const Vec3 sun = view.light.direction;
  // Clamped: with long shadows of a low sun everything else would be small.
  const Real lean = sun.y < 0 ? std::min(1.0, 0.6 * -sun.y / std::hypot(sun.x, sun.z)) : 0;
  const std::size_t count = balls.size();
  for (std::size_t i = 0; i < count; ++i) {
    Ball& ball = balls[i];
    const Real height = ball.centre.y - ground;
    if (height < 0) {
      ball.centre.y = ground;
      continue;
    }
    const Vec3 foot{ball.centre.x, ground, ball.centre.z};
    balls.push_back({foot, 0});
    if (sun.y < 0) {
      const Vec3 cast = foot + height * lean / -sun.y * Vec3{sun.x, 0, sun.z};
      balls.push_back({cast, 0});
    }
  }
}

/// The nearest eye whose view frustum contains all balls.
///
/// A ball (x, y, z; r) in camera axes is inside the right plane if x - e_x + r / cos <= (z - e_z)
/// tan, and likewise for the left. The sum of the two bounds e_z; e_x is in the middle. [half-space
/// fit]
Vec3 fit(const std::vector<Ball>& balls, const Eye& look, Real tan_x, Real tan_y) {
  Vec3 sides[2] = {Vec3{-kFar}, Vec3{-kFar}};  // extremes of x, y towards + and towards -
  Real nearest = kFar;
  const Real slope_x = std::sqrt(1 + tan_x * tan_x), slope_y = std::sqrt(1 + tan_y * tan_y);
  for (const Ball& b : balls) {
    const Real x = glm::dot(look.right, b.centre), y = glm::dot(look.up, b.centre);
    const Real z = glm::dot(look.forward, b.centre);
    for (int s = 0; s < 2; ++s) {
      const Real sign = s == 0 ? 1 : -1;
      sides[s].x = std::max(sides[s].x, sign * x + b.radius * slope_x - z * tan_x);
      sides[s].y = std::max(sides[s].y, sign * y + b.radius * slope_y - z * tan_y);
    }
    nearest = std::min(nearest, z - b.radius);
  }
  const Real back = std::min({-(sides[0].x + sides[1].x) / (2 * tan_x),
                              -(sides[0].y + sides[1].y) / (2 * tan_y), nearest - 1e-3});
  return (sides[0].x - sides[1].x) / 2 * look.right + (sides[0].y - sides[1].y) / 2 * look.up +
         back * look.forward;
}

/// Seen from here the rim of a cavity hides little of what is in it.
const Vec3 kIntoCavity{1.2, 3, 2.4};

bool is_default(const Camera& camera) {
  return camera.eye == Camera{}.eye && camera.target == Camera{}.target;
}

/// Whether a shape may contain bodies: a mesh, or a surface that is no closed convex one.
bool is_hollow(const Shape& shape) {
  if (!shape.surface) return false;
  const ShapeClass of = traits_of(shape.kind).shape_class;
  const SkinModel* model = shape.surface->model.get();
  return of == ShapeClass::mesh || (of == ShapeClass::skin && model && !model->is_convex);
}

/// Whether the bounds of a hollow shape contain another body's mass centre.
bool has_cavity(const World& world) {
  const auto bodies = world.bodies.values();
  for (std::size_t i = 0; i < world.shapes.size(); ++i) {
    const std::uint32_t own = world.bodies.slot(world.shapes.owners()[i]);
    for (const Shape& shape : world.shapes.values()[i].list) {
      if (own == kNoSlot || !is_hollow(shape)) continue;
      const Pose into = inverse(compose(bodies[own].pose, shape.local));
      for (std::uint32_t slot = 0; slot < bodies.size(); ++slot) {
        if (slot == own || bodies[slot].motion != Motion::dynamic) continue;
        const Vec3 p = to_world(into, bodies[slot].pose.position);
        if (glm::all(glm::greaterThan(p, shape.surface->low)) &&
            glm::all(glm::lessThan(p, shape.surface->high)))
          return true;
      }
    }
  }
  return false;
}

/// The height of the highest fixed plane that faces up; -infinity without one.
Real level_of_planes(const World& world) {
  Real level = -kFar;
  for (std::size_t i = 0; i < world.shapes.size(); ++i) {
    const std::uint32_t slot = world.bodies.slot(world.shapes.owners()[i]);
    if (slot == kNoSlot || world.bodies.values()[slot].motion != Motion::fixed) continue;
    for (const Shape& shape : world.shapes.values()[i].list) {
      const Pose at = compose(world.bodies.values()[slot].pose, shape.local);
      const bool flat = traits_of(shape.kind).shape_class == ShapeClass::half_space;
      if (flat && (at.rotation * Vec3{0, 1, 0}).y > 1 - 1e-9)
        level = std::max(level, at.position.y);
    }
  }
  return level;
}

View with_ground(const World& world, View view) {
  view.ground_height = ground_height_of(world, view);
  return view;
}

}  // namespace

Eye make_eye(const Camera& camera, int width, int height) {
  Eye eye;
  eye.width = width, eye.height = height;
  eye.position = camera.eye;
  const Vec3 way = camera.target - camera.eye;
  const Real distance = glm::length(way);
  eye.forward = distance > 0 ? way / distance : Vec3{0, 0, -1};
  // If it looks straight up or down, the top of the picture is towards -z or z.
  const Vec3 up =
      std::abs(eye.forward.y) < 0.9999 ? Vec3{0, 1, 0} : Vec3{0, 0, eye.forward.y > 0 ? 1 : -1};
  eye.right = glm::normalize(glm::cross(eye.forward, up));
  eye.up = glm::cross(eye.right, eye.forward);
  eye.tan_y = std::tan(std::clamp(camera.field_of_view, 0.01, 3.0) / 2);
  eye.tan_x = eye.tan_y * width / height;
  eye.distance = distance > 0 ? distance : 1;
  return eye;
}

}  // namespace pantin::detail

namespace pantin {

using namespace detail;

Camera framing_camera(const World& world, const View& view, Real aspect) {
  constexpr Real kMargin = 0.92;  // fraction of the picture that is filled
  Camera camera = view.camera;
  camera.automatic = false;
  std::vector<Ball> balls = all_balls(world);
  if (balls.empty()) return camera;
  add_ground(with_ground(world, view), balls);
  if (is_default(camera) && has_cavity(world)) camera.eye = camera.target + kIntoCavity;
  const Eye look = make_eye(camera, 1, 1);
  const Real tan_y = kMargin * look.tan_y;
  camera.eye = fit(balls, look, tan_y * aspect, tan_y);
  Real low = kFar, high = -kFar;
  for (const Ball& b : balls) {
    low = std::min(low, glm::dot(look.forward, b.centre - camera.eye));
    high = std::max(high, glm::dot(look.forward, b.centre - camera.eye));
  }
  camera.target = camera.eye + std::max((low + high) / 2, 1e-3) * look.forward;
  return camera;
}

Real ground_height_of(const World& world, const View& view) {
  if (std::isfinite(view.ground_height)) return view.ground_height;
  if (const Real level = level_of_planes(world); std::isfinite(level)) return level;
  Real low = 0;
  for (const Ball& b : all_balls(world)) low = std::min(low, b.centre.y - b.radius);
  return low;
}

View framed_view(const World& world, const View& view, Real aspect) {
  View framed = with_ground(world, view);
  if (view.camera.automatic) framed.camera = framing_camera(world, framed, aspect);
  return framed;
}

Camera seen_from(Vec3 way, const Camera& from) {
  Camera camera = from;
  camera.eye = from.target + glm::distance(from.eye, from.target) * way;
  return camera;
}

}  // namespace pantin
