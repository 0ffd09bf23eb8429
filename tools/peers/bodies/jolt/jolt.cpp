// A scene in Jolt, as its manual shows it: one Update of 1/60 s a frame on one thread, settings as
// they come, masses and inertias those of the scene.
// clang-format off
#include <Jolt/Jolt.h>  // before all others of the engine
// clang-format on

#include <Jolt/Core/Factory.h>
#include <Jolt/Core/JobSystemSingleThreaded.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Physics/Body/BodyCreationSettings.h>
#include <Jolt/Physics/Collision/GroupFilterTable.h>
#include <Jolt/Physics/Collision/Shape/BoxShape.h>
#include <Jolt/Physics/Collision/Shape/CapsuleShape.h>
#include <Jolt/Physics/Collision/Shape/ConvexHullShape.h>
#include <Jolt/Physics/Collision/Shape/CylinderShape.h>
#include <Jolt/Physics/Collision/Shape/OffsetCenterOfMassShape.h>
#include <Jolt/Physics/Collision/Shape/RotatedTranslatedShape.h>
#include <Jolt/Physics/Collision/Shape/SphereShape.h>
#include <Jolt/Physics/Collision/Shape/StaticCompoundShape.h>
#include <Jolt/Physics/Constraints/DistanceConstraint.h>
#include <Jolt/Physics/Constraints/FixedConstraint.h>
#include <Jolt/Physics/Constraints/HingeConstraint.h>
#include <Jolt/Physics/Constraints/PointConstraint.h>
#include <Jolt/Physics/Constraints/SixDOFConstraint.h>
#include <Jolt/Physics/Constraints/SwingTwistConstraint.h>
#include <Jolt/Physics/PhysicsSystem.h>
#include <Jolt/RegisterTypes.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "tools/peers/bodies/motion.hpp"
#include "tools/peers/bodies/spelt.hpp"

namespace {

using namespace JPH;
using namespace pantin::peers;

/// The settings that it comes with, or those for long chains of its manual, and no limits of speed.
enum class Chosen { defaults, accurate };

Vec3 vec(const Three& v) { return Vec3(v[0], v[1], v[2]); }
RVec3 place(const Three& v) { return RVec3(Real(v[0]), Real(v[1]), Real(v[2])); }
Quat quat(const Four& q) { return Quat(q[0], q[1], q[2], q[3]).Normalized(); }

// ---- Layers ------------------------------------------------------------------------------------

/// Twice a layer of the scene, which counts from -1, plus one for what moves.
ObjectLayer layer_of(const SpeltBody& b) {
  return static_cast<ObjectLayer>(2 * (b.layer + 1) + (b.motion == "fixed" ? 0 : 1));
}

constexpr BroadPhaseLayer kStill(0), kMoving(1);
BroadPhaseLayer broad(ObjectLayer layer) { return layer % 2 == 0 ? kStill : kMoving; }

class BroadPhaseLayers final : public BroadPhaseLayerInterface {
 public:
  uint GetNumBroadPhaseLayers() const override { return 2; }
  BroadPhaseLayer GetBroadPhaseLayer(ObjectLayer layer) const override { return broad(layer); }
#if defined(JPH_EXTERNAL_PROFILE) || defined(JPH_PROFILE_ENABLED)
  const char* GetBroadPhaseLayerName(BroadPhaseLayer) const override { return "layer"; }
#endif
};

class PairsOfLayers final : public ObjectLayerPairFilter {
 public:
  explicit PairsOfLayers(const Spelt& scene) : touch_(scene.touch) {}
  bool ShouldCollide(ObjectLayer a, ObjectLayer b) const override {
    return a > 1 && b > 1 && touch_[a / 2u - 1][b / 2u - 1];
  }

 private:
  const std::vector<std::vector<bool>>& touch_;
};

class LayersOfBroadPhase final : public ObjectVsBroadPhaseLayerFilter {
 public:
  bool ShouldCollide(ObjectLayer a, BroadPhaseLayer b) const override {
    return broad(a) == kMoving || b == kMoving;
  }
};

// ---- Shapes ------------------------------------------------------------------------------------

/// Roundings are those that come with the engine, where a shape is big enough for them.
float rounding(float least) { return std::min(cDefaultConvexRadius, 0.5f * least); }

Ref<Shape> built(const ShapeSettings& settings) {
  ShapeSettings::ShapeResult result = settings.Create();
  if (result.HasError()) {
    std::fprintf(stderr, "peers_jolt: %s\n", result.GetError().c_str());
    std::exit(2);
  }
  return result.Get();
}

Ref<Shape> shape_of(const SpeltShape& s) {
  if (s.kind == "sphere") return new SphereShape(s.size[0]);
  if (s.kind == "capsule") return built(CapsuleShapeSettings(s.size[1], s.size[0]));
  if (s.kind == "cylinder")
    return built(
        CylinderShapeSettings(s.size[1], s.size[0], rounding(std::min(s.size[0], s.size[1]))));
  if (s.kind == "box") {
    const float least = std::min({s.size[0], s.size[1], s.size[2]});
    return built(BoxShapeSettings(vec(s.size), rounding(least)));
  }
  if (s.kind == "plane") {  // Jolt 5.0 has no half-space
    constexpr float kWide = 200, kDeep = 5;
    const Ref<Shape> slab = built(BoxShapeSettings(Vec3(kWide, kDeep, kWide)));
    return built(RotatedTranslatedShapeSettings(Vec3(0, -kDeep, 0), Quat::sIdentity(), slab));
  }
  Array<Vec3> points;
  for (const Three& p : s.points) points.push_back(vec(p));
  return built(ConvexHullShapeSettings(points, rounding(0.1f)));
}

/// All shapes of a body, their mass centre at its origin.
Ref<Shape> shape_of(const SpeltBody& b) {
  if (b.shapes.empty()) return new SphereShape(0.01f);
  Ref<Shape> shape;
  if (b.shapes.size() == 1) {
    const SpeltShape& only = b.shapes[0];
    shape = shape_of(only);
    const bool shifted =
        !vec(only.at.position).IsNearZero() || !quat(only.at.rotation).IsClose(Quat::sIdentity());
    if (shifted)
      shape = built(
          RotatedTranslatedShapeSettings(vec(only.at.position), quat(only.at.rotation), shape));
  } else {
    StaticCompoundShapeSettings all;
    for (const SpeltShape& s : b.shapes)
      all.AddShape(vec(s.at.position), quat(s.at.rotation), shape_of(s));
    shape = built(all);
  }
  const Vec3 centre = shape->GetCenterOfMass();
  return centre.IsNearZero() ? shape : built(OffsetCenterOfMassShapeSettings(-centre, shape));
}

// ---- Bodies ------------------------------------------------------------------------------------

Body* add_body(const SpeltBody& b, const CollisionGroup& group, BodyInterface& bodies,
               Chosen chosen) {
  const EMotionType motion = b.motion == "dynamic" ? EMotionType::Dynamic
                             : b.motion == "fixed" ? EMotionType::Static
                                                   : EMotionType::Kinematic;
  BodyCreationSettings settings(shape_of(b), place(b.at.position), quat(b.at.rotation), motion,
                                layer_of(b));
  settings.mLinearVelocity = vec(b.velocity), settings.mAngularVelocity = vec(b.spin);
  settings.mLinearDamping = settings.mAngularDamping = b.drag;
  settings.mFriction = b.friction, settings.mRestitution = b.restitution;
  settings.mGravityFactor = b.gravity;
  settings.mCollisionGroup = group;
  if (chosen == Chosen::accurate) settings.mMaxAngularVelocity = settings.mMaxLinearVelocity = 1e6f;
  settings.mOverrideMassProperties = EOverrideMassProperties::MassAndInertiaProvided;
  settings.mMassPropertiesOverride.mMass = b.mass;
  settings.mMassPropertiesOverride.mInertia = Mat44::sScale(vec(b.inertia));
  Body* body = bodies.CreateBody(settings);
  bodies.AddBody(body->GetID(),
                 motion == EMotionType::Static ? EActivation::DontActivate : EActivation::Activate);
  return body;
}

// ---- Joints ------------------------------------------------------------------------------------

struct Axes {
  Vec3 x, y, z;
  explicit Axes(const Four& q)
      : x(quat(q).RotateAxisX()), y(quat(q).RotateAxisY()), z(quat(q).RotateAxisZ()) {}
};

/// Settings whose constraint spaces are the joint axes of both bodies.
template <class Settings>
void place_axes(Settings& s, const SpeltJoint& j) {
  const Axes a(j.axes_a), b(j.axes_b);
  s.mSpace = EConstraintSpace::LocalToBodyCOM;
  if constexpr (requires { s.mPoint1; })
    s.mPoint1 = place(j.anchor_a), s.mPoint2 = place(j.anchor_b);
  else
    s.mPosition1 = place(j.anchor_a), s.mPosition2 = place(j.anchor_b);
  if constexpr (requires { s.mAxisX1; }) {
    s.mAxisX1 = a.x, s.mAxisY1 = a.y, s.mAxisX2 = b.x, s.mAxisY2 = b.y;
  } else if constexpr (requires { s.mTwistAxis1; }) {
    s.mTwistAxis1 = a.x, s.mPlaneAxis1 = a.z, s.mTwistAxis2 = b.x, s.mPlaneAxis2 = b.z;
  } else if constexpr (requires { s.mHingeAxis1; }) {
    s.mHingeAxis1 = a.x, s.mNormalAxis1 = a.y, s.mHingeAxis2 = b.x, s.mNormalAxis2 = b.y;
  }
}

MotorSettings motor_of(const SpeltDrive& drive) {
  MotorSettings motor;
  motor.mSpringSettings.mMode = ESpringMode::StiffnessAndDamping;
  motor.mSpringSettings.mStiffness = drive.stiffness;
  motor.mSpringSettings.mDamping = drive.damping;
  motor.SetTorqueLimit(drive.most);
  return motor;
}

/// A joint, and how its drive takes a target, if it has one.
struct Built {
  Ref<Constraint> constraint;
  HingeConstraint* hinge = nullptr;
  SwingTwistConstraint* cone = nullptr;
  SixDOFConstraint* universal = nullptr;
  void aim(const Four& at) const {
    const Quat target = quat(at);
    if (hinge) hinge->SetTargetAngle(2 * ATan2(target.GetX(), target.GetW()));
    if (cone) cone->SetTargetOrientationCS(target);
    if (universal) universal->SetTargetOrientationCS(target);
  }
};

Built build_hinge(const SpeltJoint& j, Body& a, Body& b) {
  HingeConstraintSettings s;
  place_axes(s, j);
  if (j.first.on) {
    // Ranges have to hold the zero.
    const float shift = std::clamp(0.0f, j.first.low, j.first.high);
    s.mNormalAxis1 = Quat::sRotation(s.mHingeAxis1, shift) * s.mNormalAxis1;
    s.mLimitsMin = std::max(j.first.low - shift, -JPH_PI);
    s.mLimitsMax = std::min(j.first.high - shift, JPH_PI);
  }
  Built built;
  if (!j.drive.targets.empty()) s.mMotorSettings = motor_of(j.drive);
  built.hinge = static_cast<HingeConstraint*>(s.Create(a, b));
  built.constraint = built.hinge;
  if (!j.drive.targets.empty()) built.hinge->SetMotorState(EMotorState::Position);
  return built;
}

Built build_cone(const SpeltJoint& j, Body& a, Body& b) {
  SwingTwistConstraintSettings s;
  place_axes(s, j);
  s.mTwistMinAngle = j.first.on ? j.first.low : -JPH_PI;
  s.mTwistMaxAngle = j.first.on ? j.first.high : JPH_PI;
  s.mPlaneHalfConeAngle = j.swing.on ? j.swing.low : JPH_PI;    // about y
  s.mNormalHalfConeAngle = j.swing.on ? j.swing.high : JPH_PI;  // about z
  if (!j.drive.targets.empty()) s.mSwingMotorSettings = s.mTwistMotorSettings = motor_of(j.drive);
  Built built;
  built.cone = static_cast<SwingTwistConstraint*>(s.Create(a, b));
  built.constraint = built.cone;
  if (!j.drive.targets.empty()) {
    built.cone->SetSwingMotorState(EMotorState::Position);
    built.cone->SetTwistMotorState(EMotorState::Position);
  }
  return built;
}

Built build_universal(const SpeltJoint& j, Body& a, Body& b) {
  using Axis = SixDOFConstraintSettings::EAxis;
  SixDOFConstraintSettings s;
  place_axes(s, j);
  s.mSwingType = ESwingType::Pyramid;
  for (const Axis axis :
       {Axis::TranslationX, Axis::TranslationY, Axis::TranslationZ, Axis::RotationX})
    s.MakeFixedAxis(axis);
  if (j.first.on) s.SetLimitedAxis(Axis::RotationY, j.first.low, j.first.high);
  if (j.second.on) s.SetLimitedAxis(Axis::RotationZ, j.second.low, j.second.high);
  if (!j.drive.targets.empty())
    s.mMotorSettings[Axis::RotationY] = s.mMotorSettings[Axis::RotationZ] = motor_of(j.drive);
  Built built;
  built.universal = static_cast<SixDOFConstraint*>(s.Create(a, b));
  built.constraint = built.universal;
  if (!j.drive.targets.empty())
    for (const Axis axis : {Axis::RotationY, Axis::RotationZ})
      built.universal->SetMotorState(axis, EMotorState::Position);
  return built;
}

Built build(const SpeltJoint& j, Body& a, Body& b) {
  if (j.kind == "hinge") return build_hinge(j, a, b);
  if (j.kind == "universal") return build_universal(j, a, b);
  Built built;
  if (j.kind == "fixed") {
    FixedConstraintSettings s;
    place_axes(s, j);
    built.constraint = s.Create(a, b);
  } else if (j.first.on || j.swing.on || !j.drive.targets.empty()) {
    return build_cone(j, a, b);
  } else {
    PointConstraintSettings s;
    place_axes(s, j);
    built.constraint = s.Create(a, b);
  }
  return built;
}

Ref<Constraint> build(const SpeltCable& c, Body& a, Body& b) {
  DistanceConstraintSettings s;
  s.mSpace = EConstraintSpace::LocalToBodyCOM;
  s.mPoint1 = place(c.anchor_a), s.mPoint2 = place(c.anchor_b);
  s.mMinDistance = 0, s.mMaxDistance = c.length;
  if (c.compliance > 0) {
    s.mLimitsSpringSettings.mMode = ESpringMode::StiffnessAndDamping;
    s.mLimitsSpringSettings.mStiffness = 1 / c.compliance;
    s.mLimitsSpringSettings.mDamping = 0;
  }
  return s.Create(a, b);
}

// ---- The run -----------------------------------------------------------------------------------

PhysicsSettings settings_of(Chosen chosen) {
  PhysicsSettings settings;
  if (chosen == Chosen::accurate) settings.mNumVelocitySteps = 50, settings.mNumPositionSteps = 10;
  return settings;
}

class Run {
 public:
  Run(const Spelt& scene, int steps, Chosen chosen) : scene_(scene), steps_(steps), pairs_(scene) {
    const auto count = static_cast<uint>(scene.bodies.size());
    system_.Init(count + 16, 0, 65536, 32768, broad_, lower_, pairs_);
    system_.SetPhysicsSettings(settings_of(chosen));
    system_.SetGravity(vec(scene.gravity));
    Ref<GroupFilterTable> jointed = new GroupFilterTable(count);
    for (const SpeltJoint& j : scene.joints)
      if (j.a >= 0 && j.b >= 0 && j.a != j.b)
        jointed->DisableCollision(static_cast<uint>(j.a), static_cast<uint>(j.b));
    for (uint i = 0; i < count; ++i)
      bodies_.push_back(add_body(scene.bodies[i], CollisionGroup(jointed, 0, i),
                                 system_.GetBodyInterface(), chosen));
    for (const SpeltJoint& j : scene.joints) {
      joints_.push_back(build(j, body(j.a), body(j.b)));
      system_.AddConstraint(joints_.back().constraint);
    }
    for (const SpeltCable& c : scene.cables) system_.AddConstraint(build(c, body(c.a), body(c.b)));
    system_.OptimizeBroadPhase();
  }

  void step(std::size_t part) {
    BodyInterface& all = system_.GetBodyInterface();
    for (std::size_t i = 0; i < bodies_.size(); ++i)
      if (const std::vector<SpeltPose>& path = scene_.bodies[i].path; part < path.size())
        all.MoveKinematic(bodies_[i]->GetID(), place(path[part].position),
                          quat(path[part].rotation), h_);
    for (std::size_t i = 0; i < joints_.size(); ++i)
      if (const std::vector<Four>& targets = scene_.joints[i].drive.targets; !targets.empty())
        joints_[i].aim(targets[std::min(part, targets.size() - 1)]);
    push();
    system_.Update(h_, steps_, &memory_, &jobs_);
  }

  void read(Frame& to) const {
    to.awake = 0;
    to.bodies.resize(bodies_.size());
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const Body& b = *bodies_[i];
      const RVec3 x = b.GetCenterOfMassPosition();
      const Quat q = b.GetRotation();
      Vec3 v = Vec3::sZero(), w = Vec3::sZero();
      if (!b.IsStatic()) v = b.GetLinearVelocity(), w = b.GetAngularVelocity();
      to.bodies[i] = {{x.GetX(), x.GetY(), x.GetZ()},
                      {q.GetX(), q.GetY(), q.GetZ(), q.GetW()},
                      {v.GetX(), v.GetY(), v.GetZ()},
                      {w.GetX(), w.GetY(), w.GetZ()}};
      if (b.IsDynamic() && b.IsActive()) ++to.awake;
    }
  }

 private:
  Body& body(int number) {
    return number < 0 ? Body::sFixedToWorld : *bodies_[static_cast<std::size_t>(number)];
  }

  /// Loads the bodies with what springs and torques come to now.
  void push() {
    load(
        scene_,
        [&](int i, const Three& local) {
          const RVec3 at = body(i).GetCenterOfMassTransform() * vec(local);
          return Three{at.GetX(), at.GetY(), at.GetZ()};
        },
        [&](int i, const Three& at, const Three& force) {
          if (i >= 0) body(i).AddForce(vec(force), place(at));
        },
        [&](int i, const Three& torque) { body(i).AddTorque(vec(torque)); });
  }

  const Spelt& scene_;
  int steps_;
  float h_ = 1.0f / float(scene_.rate * scene_.parts);  // s
  BroadPhaseLayers broad_;
  LayersOfBroadPhase lower_;
  PairsOfLayers pairs_;
  TempAllocatorImpl memory_{256 << 20};
  JobSystemSingleThreaded jobs_{cMaxPhysicsJobs};
  PhysicsSystem system_;
  std::vector<Body*> bodies_;
  std::vector<Built> joints_;
};

}  // namespace

int main(int count, char** words) {
  Spelt scene;
  const Chosen chosen =
      count == 5 && std::string(words[4]) == "best" ? Chosen::accurate : Chosen::defaults;
  const int steps =
      count == 4 || chosen == Chosen::accurate ? std::max(1, std::atoi(words[3])) : 0;  // 0: 1
  if (steps == 0 || !read_spelt(words[1], scene)) {
    std::fputs(
        "usage: peers_jolt SPELT OUT STEPS [best]     collision steps of a part of a frame\n",
        stderr);
    return 2;
  }
  for (const SpeltBody& b : scene.bodies)
    if (b.motion == "dynamic" && vec(b.inertia).IsNearZero()) {
      std::fprintf(stderr, "peers_jolt: found the inertia of %s, which Jolt takes for none\n",
                   b.name.c_str());
      return 3;
    }
  RegisterDefaultAllocator();
  Factory::sInstance = new Factory();
  RegisterTypes();
  char told[160];
  MotionWriter out(words[2]);
  out.tell("engine", "jolt");
  std::snprintf(told, sizeof told, "%d.%d.%d", JPH_VERSION_MAJOR, JPH_VERSION_MINOR,
                JPH_VERSION_PATCH);
  out.tell("version", told);
  const PhysicsSettings settings = settings_of(chosen);
  std::snprintf(told, sizeof told,
                "%s (%u velocity, %u position iterations), %d collision step%s a frame, 1 thread",
                chosen == Chosen::accurate ? "no limits of speed" : "defaults",
                settings.mNumVelocitySteps, settings.mNumPositionSteps, steps * scene.parts,
                steps * scene.parts == 1 ? "" : "s");
  out.tell("settings", told), out.tell("built", PANTIN_PEERS_FLAGS);
  for (const std::string& what : scene.unknown) out.tell("without", what);
  out.begin(scene.bodies.size());
  {
    Run run(scene, steps, chosen);
    Frame frame;
    for (int i = 0; i < scene.frames; ++i) {
      const double before = cpu_ms();
      for (int part = i * scene.parts; part < (i + 1) * scene.parts; ++part)
        run.step(static_cast<std::size_t>(part));
      frame.ms = cpu_ms() - before;
      run.read(frame);
      out.add(frame);
    }
  }
  UnregisterTypes();
  delete Factory::sInstance;
  return out.good() ? 0 : 2;
}
