// A human figure, 1.76 m tall before scaling; x to its left, y up, z forwards.
#include <pantin/figures.hpp>

#include "engine/base/rotation.hpp"
#include "engine/pantin/detail/builder.hpp"
#include "engine/pantin/detail/findings.hpp"

namespace pantin {

using namespace detail;

namespace {

constexpr Real kTall = 1.76;  // m, height of the dimensions below
constexpr Real kDegree = kPi / 180;

/// Builds in the figure's own frame and size.
class Figure {
 public:
  Figure(World& world, const RagdollOptions& options, Real density)
      : builder_(world, options.name),
        options_(options),
        density_(density),
        scale_(options.height / kTall),
        frame_{options.position, glm::normalize(options.rotation)} {}

  Entity body(const char* part, Vec3 at, std::vector<BodyShape> shapes) {
    for (BodyShape& s : shapes) std::visit([&](auto& shape) { scale(shape); }, s);
    RigidBody body;
    body.shapes = std::move(shapes);
    body.density = density_, body.drag = options_.drag, body.collision = options_.collision;
    body.position = point(at), body.rotation = frame_.rotation;
    return builder_.add(body, part);
  }
  template <class T>
  Entity joint(const std::string& part, T joint, Vec3 at) {
    joint.anchor = point(at);
    return builder_.add(joint, part);
  }
  Vec3 direction(Vec3 v) const { return frame_.rotation * v; }
  bool ok() const { return builder_.ok(); }
  std::vector<Error> take() { return builder_.take(); }

 private:
  Vec3 point(Vec3 at) const { return to_world(frame_, scale_ * at); }
  static void scale(std::monostate&) {}
  void scale(SphereShape& s) { s.radius *= scale_, s.at.position *= scale_; }
  void scale(CapsuleShape& s) {
    s.radius *= scale_, s.half_length *= scale_, s.at.position *= scale_;
  }
  void scale(BoxShape& s) { s.half_extents *= scale_, s.at.position *= scale_; }
  template <class T>
  static void scale(T&) {}

  Builder builder_;
  const RagdollOptions& options_;
  Real density_, scale_;
  Pose frame_;
};

const char* side_name(std::size_t side) { return side == 0 ? "_l" : "_r"; }

Pose lying() { return {Vec3(0), from_rotation_vector(Vec3(0, 0, kPi / 2))}; }

void add_bodies(Figure& f, Ragdoll& r) {
  r.pelvis = f.body("pelvis", {0, 0.95, 0}, {CapsuleShape{0.1, 0.07, lying()}});
  Pose shoulders = lying();
  shoulders.position = {0, 0.16, 0};
  r.chest = f.body("chest", {0, 1.27, 0},
                   {CapsuleShape{0.13, 0.09, {{0, -0.02, 0}}}, CapsuleShape{0.06, 0.15, shoulders},
                    CapsuleShape{0.05, 0.05, {{0, 0.22, 0}}}});
  r.head = f.body("head", {0, 1.65, 0}, {SphereShape{0.11}});
  for (std::size_t i = 0; i < 2; ++i) {
    const Real side = i == 0 ? 1 : -1;
    const std::string suffix = side_name(i);
    const auto limb = [&](const char* name, Vec3 at, std::vector<BodyShape> shapes) {
      return f.body((name + suffix).c_str(), {side * at.x, at.y, at.z}, std::move(shapes));
    };
    r.upper_arms[i] = limb("upper_arm", {0.225, 1.29, 0}, {CapsuleShape{0.046, 0.11}});
    r.forearms[i] = limb("forearm", {0.225, 1.02, 0},
                         {CapsuleShape{0.036, 0.1}, SphereShape{0.05, {{0, -0.15, 0}}}});
    r.thighs[i] = limb("thigh", {0.095, 0.69, 0}, {CapsuleShape{0.072, 0.16}});
    r.shins[i] = limb("shin", {0.095, 0.29, 0}, {CapsuleShape{0.05, 0.15}});
    r.feet[i] = limb("foot", {0.095, 0.03, 0.05}, {BoxShape{{0.0475, 0.03, 0.125}}});
  }
}

struct Ends {
  Entity a, b;
};

/// The range of a limb's swing sideways and forwards and of its twist, degrees.
struct LimbRange {
  Real y = 0, z = 0, twist = 0;
};

BallJoint ball(const Figure& f, Ends ends, Vec3 axis, LimbRange range) {
  return {.a = ends.a,
          .b = ends.b,
          .axis = f.direction(axis),
          .across = f.direction({1, 0, 0}),
          .cone = ConeLimit{range.y * kDegree, range.z * kDegree},
          .twist = Interval{-range.twist * kDegree, range.twist * kDegree}};
}

HingeJoint hinge(const Figure& f, Ends ends, Vec3 axis, Real most) {
  return {
      .a = ends.a, .b = ends.b, .axis = f.direction(axis), .limits = Interval{0, most * kDegree}};
}

void add_joints(Figure& f, Ragdoll& r) {
  r.waist = f.joint("waist", ball(f, {r.pelvis, r.chest}, {0, 1, 0}, {45, 25, 35}), {0, 1.06, 0});
  r.neck = f.joint("neck", ball(f, {r.chest, r.head}, {0, 1, 0}, {45, 35, 60}), {0, 1.53, 0});
  for (std::size_t i = 0; i < 2; ++i) {
    const Real side = i == 0 ? 1 : -1;
    const std::string suffix = side_name(i);
    BallJoint shoulder = ball(f, {r.chest, r.upper_arms[i]}, {0, -1, 0}, {95, 85, 75});
    shoulder.cone_axis = f.direction({side * 0.5, -0.6, 0.6});
    r.shoulders[i] = f.joint("shoulder" + suffix, shoulder, {side * 0.225, 1.43, 0});
    r.elbows[i] =
        f.joint("elbow" + suffix, hinge(f, {r.upper_arms[i], r.forearms[i]}, {-1, 0, 0}, 145),
                {side * 0.225, 1.15, 0});
    BallJoint hip = ball(f, {r.pelvis, r.thighs[i]}, {0, -1, 0}, {65, 40, 35});
    hip.cone_axis = f.direction({side * 0.15, -0.75, 0.65});
    r.hips[i] = f.joint("hip" + suffix, hip, {side * 0.095, 0.9, 0});
    r.knees[i] = f.joint("knee" + suffix, hinge(f, {r.thighs[i], r.shins[i]}, {1, 0, 0}, 140),
                         {side * 0.095, 0.49, 0});
    const UniversalJoint ankle{.a = r.shins[i],
                               .b = r.feet[i],
                               .axis_a = f.direction({1, 0, 0}),
                               .axis_b = f.direction({0, 0, 1}),
                               .limits = Interval{-45 * kDegree, 25 * kDegree},
                               .second_limits = Interval{-15 * kDegree, 15 * kDegree}};
    r.ankles[i] = f.joint("ankle" + suffix, ankle, {side * 0.095, 0.08, 0});
  }
}

/// The mass of the figure at density 1.
Real unit_mass(const RagdollOptions& options) {
  World scratch;
  RagdollOptions plain;
  plain.height = options.height;
  Figure figure(scratch, plain, 1);
  Ragdoll r;
  add_bodies(figure, r);
  Real mass = 0;
  for (const Body& b : scratch.bodies.values()) mass += b.mass;
  return mass;
}

}  // namespace

Result<Ragdoll> build_ragdoll(World& world, const RagdollOptions& options) {
  Findings findings(world, "Ragdoll", options.name);
  findings.above_zero("height", options.height), findings.above_zero("mass", options.mass);
  findings.finite("position", options.position), findings.rotation("rotation", options.rotation);
  if (!findings.ok()) return findings.take();
  Figure figure(world, options, options.mass / unit_mass(options));
  Ragdoll r;
  add_bodies(figure, r);
  if (figure.ok()) add_joints(figure, r);
  if (!figure.ok()) return figure.take();
  return r;
}

std::vector<Entity> Ragdoll::bodies() const {
  std::vector<Entity> all{pelvis, chest, head};
  for (const auto* pair : {&upper_arms, &forearms, &thighs, &shins, &feet})
    all.insert(all.end(), pair->begin(), pair->end());
  return all;
}

std::vector<Entity> Ragdoll::joints() const {
  std::vector<Entity> all{waist, neck};
  for (const auto* pair : {&shoulders, &elbows, &hips, &knees, &ankles})
    all.insert(all.end(), pair->begin(), pair->end());
  return all;
}

}  // namespace pantin
