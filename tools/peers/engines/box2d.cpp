// Box2D 2.4: scenes that stay in the xy plane, joined by hinges or by balls that turn about z
// alone.
#include <box2d/box2d.h>

#include "tools/peers/engines/engine.hpp"

namespace {

using namespace pantin::peers;

/// The angle about z of a rotation that leaves the plane where it is.
double angle_of(const Four& q) { return 2 * std::atan2(q[2], q[3]); }

/// Where a point of a body lies in the plane: axes of bodies may point anywhere at angle 0.
b2Vec2 turned(const Four& q, const Three& v, double back) {
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  const double tx = 2 * (y * v[2] - z * v[1]), ty = 2 * (z * v[0] - x * v[2]);
  const double tz = 2 * (x * v[1] - y * v[0]);
  const double px = v[0] + w * tx + y * tz - z * ty, py = v[1] + w * ty + z * tx - x * tz;
  const double c = std::cos(back), s = std::sin(back);
  return {float(c * px + s * py), float(-s * px + c * py)};
}

/// The moment of inertia about z.
double about_z(const Four& q, const Three& i) {
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  const double a = 2 * (x * z - y * w), b = 2 * (y * z + x * w), c = 1 - 2 * (x * x + y * y);
  return a * a * i[0] + b * b * i[1] + c * c * i[2];
}

class Box2dRun final : public EngineRun {
 public:
  Box2dRun(const Spelt& scene, int velocity, int position)
      : scene_(scene),
        velocity_(velocity),
        position_(position),
        world_(b2Vec2(float(scene.gravity[0]), float(scene.gravity[1]))) {
    world_.SetAllowSleeping(false);
    const b2BodyDef still;
    still_ = world_.CreateBody(&still);
    for (const SpeltBody& b : scene.bodies) add(b);
    for (const SpeltJoint& j : scene.joints) join(j);
  }

  bool advance() override {
    const double h = step_of(scene_);
    for (int part = 0; part < scene_.parts; ++part, ++part_) {
      for (std::size_t i = 0; i < bodies_.size(); ++i) lead(i, h);
      push();
      world_.Step(float(h), velocity_, position_);
    }
    return true;
  }

  void read(Frame& to) override {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const b2Vec2 x = bodies_[i]->GetPosition();
      to.bodies[i].position[0] = x.x, to.bodies[i].position[1] = x.y;
      to.bodies[i].position[2] = scene_.bodies[i].at.position[2];
    }
  }

  std::string settings() const override {
    return "float, " + std::to_string(velocity_) + " velocity, " + std::to_string(position_) +
           " position iterations";
  }

 private:
  void add(const SpeltBody& b) {
    b2BodyDef made;
    made.type = b.motion == "dynamic" ? b2_dynamicBody : b2_kinematicBody;
    made.position.Set(float(b.at.position[0]), float(b.at.position[1]));
    made.angle = float(angle_of(b.at.rotation));
    bodies_.push_back(world_.CreateBody(&made));
    if (b.motion != "dynamic") return;
    const b2MassData mass{float(b.mass), b2Vec2(0, 0), float(about_z(b.at.rotation, b.inertia))};
    bodies_.back()->SetMassData(&mass);
  }

  b2Body* body(int i) const { return i < 0 ? still_ : bodies_[static_cast<std::size_t>(i)]; }

  /// In the axes that Box2D gives the body.
  b2Vec2 local(int i, const Three& anchor) const {
    const Four none{0, 0, 0, 1};
    const Four& q = i < 0 ? none : scene_.bodies[static_cast<std::size_t>(i)].at.rotation;
    return turned(q, anchor, angle_of(q));
  }

  void push() {
    load(
        scene_,
        [&](int i, const Three& p) {
          const b2Vec2 at = body(i)->GetWorldPoint(local(i, p));
          return Three{at.x, at.y, 0};
        },
        [&](int i, const Three& at, const Three& f) {
          body(i)->ApplyForce(b2Vec2(float(f[0]), float(f[1])), b2Vec2(float(at[0]), float(at[1])),
                              true);
        },
        [&](int i, const Three& t) { body(i)->ApplyTorque(float(t[2]), true); });
  }

  void join(const SpeltJoint& j) {
    b2RevoluteJointDef made;
    made.bodyA = body(j.a), made.bodyB = body(j.b);
    made.localAnchorA = local(j.a, j.anchor_a), made.localAnchorB = local(j.b, j.anchor_b);
    made.referenceAngle = made.bodyB->GetAngle() - made.bodyA->GetAngle();
    world_.CreateJoint(&made);
  }

  /// A body on a path starts every step at its place there, with the speed that leads to the next.
  void lead(std::size_t i, double h) {
    const std::vector<SpeltPose>& path = scene_.bodies[i].path;
    if (part_ >= path.size()) return;
    const Three& from = (part_ == 0 ? scene_.bodies[i].at : path[part_ - 1]).position;
    const Three& next = path[part_].position;
    bodies_[i]->SetTransform(b2Vec2(float(from[0]), float(from[1])), 0);
    bodies_[i]->SetLinearVelocity(
        b2Vec2(float((next[0] - from[0]) / h), float((next[1] - from[1]) / h)));
  }

  const Spelt& scene_;
  int velocity_, position_;
  b2World world_;
  b2Body* still_ = nullptr;
  std::vector<b2Body*> bodies_;
  std::size_t part_ = 0;
};

/// Whether all moves in the xy plane: bodies at one depth whose axes lie in it, hinges along z.
bool is_planar(const Spelt& scene) {
  for (const SpeltBody& b : scene.bodies)
    if (std::abs(b.at.position[2] - scene.bodies[0].at.position[2]) > 1e-12 ||
        std::abs(b.at.rotation[0]) + std::abs(b.at.rotation[1]) > 1e-12)
      return false;
  for (const SpeltJoint& j : scene.joints) {
    const Four& q = j.axes_a;
    const double along = 2 * (q[0] * q[2] - q[1] * q[3]);  // z of the x axis
    if (j.kind == "hinge" && std::abs(std::abs(along) - 1) > 1e-9) return false;
  }
  return true;
}

std::unique_ptr<EngineRun> start(const Spelt& scene, const std::string& method, double) {
  if (!is_planar(scene)) return nullptr;
  if (method == "default") return std::make_unique<Box2dRun>(scene, 8, 3);
  if (method == "40-iterations") return std::make_unique<Box2dRun>(scene, 40, 20);
  return nullptr;
}

}  // namespace

int main(int count, char** words) {
  const std::string version = std::to_string(b2_version.major) + "." +
                              std::to_string(b2_version.minor) + "." +
                              std::to_string(b2_version.revision);
  return run_engine(count, words, {"box2d", version.c_str(), start});
}
