// Bullet: rigid bodies with impulses, or its multibodies in minimal coordinates.
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include "tools/peers/engines/tree.hpp"

namespace {

using namespace pantin::peers;

btVector3 vec(const Three& v) { return {btScalar(v[0]), btScalar(v[1]), btScalar(v[2])}; }
btVector3 vec(const Eigen::Vector3d& v) {
  return {btScalar(v.x()), btScalar(v.y()), btScalar(v.z())};
}
btQuaternion quat(const Eigen::Quaterniond& q) {
  return {btScalar(q.x()), btScalar(q.y()), btScalar(q.z()), btScalar(q.w())};
}
btTransform transform(const SpeltPose& at) {
  const Four& q = at.rotation;
  return btTransform(btQuaternion(btScalar(q[0]), btScalar(q[1]), btScalar(q[2]), btScalar(q[3])),
                     vec(at.position));
}

/// The world of both, without collision.
struct Ground {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase pairs;
};

class Maximal final : public EngineRun {
 public:
  Maximal(const Spelt& scene, int iterations) : scene_(scene), iterations_(iterations) {
    world_.setGravity(vec(scene.gravity));
    world_.getSolverInfo().m_numIterations = iterations;
    still_ = add(0, btTransform::getIdentity(), btVector3(0, 0, 0));
    for (const SpeltBody& b : scene.bodies)
      bodies_.push_back(add(b.motion == "dynamic" ? b.mass : 0, transform(b.at), vec(b.inertia)));
    for (const SpeltJoint& j : scene.joints) join(j);
  }
  ~Maximal() override {
    for (const auto& joint : joints_) world_.removeConstraint(joint.get());
    for (const auto& body : all_) world_.removeRigidBody(body.get());
  }

  bool advance() override {
    const double h = step_of(scene_);
    for (int part = 0; part < scene_.parts; ++part, ++part_) {
      for (std::size_t i = 0; i < bodies_.size(); ++i) lead(i, h);
      push();
      world_.stepSimulation(btScalar(h), 0);
    }
    return true;
  }

  void read(Frame& to) override {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const btVector3& x = bodies_[i]->getWorldTransform().getOrigin();
      for (int k = 0; k < 3; ++k) to.bodies[i].position[k] = x[k];
    }
  }

  std::string settings() const override {
    return "float, sequential impulses, " + std::to_string(iterations_) + " iterations";
  }

 private:
  btRigidBody* add(double mass, const btTransform& at, const btVector3& inertia) {
    btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass), nullptr, &shape_, inertia);
    info.m_startWorldTransform = at;
    all_.push_back(std::make_unique<btRigidBody>(info));
    btRigidBody* body = all_.back().get();
    body->setDamping(0, 0), body->setActivationState(DISABLE_DEACTIVATION);
    world_.addRigidBody(body, 0, 0);
    return body;
  }

  void join(const SpeltJoint& j) {
    const auto body = [&](int i) { return i < 0 ? still_ : bodies_[static_cast<std::size_t>(i)]; };
    const auto axis = [](const Four& q) { return quat({q[3], q[0], q[1], q[2]}); };
    btRigidBody &a = *body(j.a), &b = *body(j.b);
    const btVector3 p = vec(j.anchor_a), q = vec(j.anchor_b), x(1, 0, 0);
    if (j.kind == "hinge")
      joints_.push_back(std::make_unique<btHingeConstraint>(
          a, b, p, q, quatRotate(axis(j.axes_a), x), quatRotate(axis(j.axes_b), x)));
    else
      joints_.push_back(std::make_unique<btPoint2PointConstraint>(a, b, p, q));
    world_.addConstraint(joints_.back().get(), true);
  }

  /// A body on a path starts every step at its place there, with the speed that leads to the next.
  void lead(std::size_t i, double h) {
    const std::vector<SpeltPose>& path = scene_.bodies[i].path;
    if (part_ >= path.size()) return;
    const SpeltPose& from = part_ == 0 ? scene_.bodies[i].at : path[part_ - 1];
    bodies_[i]->setWorldTransform(transform(from));
    Three velocity{};
    for (std::size_t k = 0; k < 3; ++k)
      velocity[k] = (path[part_].position[k] - from.position[k]) / h;
    bodies_[i]->setLinearVelocity(vec(velocity));
  }

  void push() {
    const auto body = [&](int i) { return i < 0 ? still_ : bodies_[static_cast<std::size_t>(i)]; };
    load(
        scene_,
        [&](int i, const Three& local) {
          const btVector3 at = body(i)->getWorldTransform() * vec(local);
          return Three{at.x(), at.y(), at.z()};
        },
        [&](int i, const Three& at, const Three& force) {
          body(i)->applyForce(vec(force), vec(at) - body(i)->getWorldTransform().getOrigin());
        },
        [&](int i, const Three& torque) { body(i)->applyTorque(vec(torque)); });
  }

  const Spelt& scene_;
  int iterations_;
  Ground ground_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&ground_.dispatcher, &ground_.pairs, &solver_,
                                 &ground_.configuration};
  btSphereShape shape_{btScalar(0.01)};
  std::vector<std::unique_ptr<btRigidBody>> all_;
  std::vector<btRigidBody*> bodies_;
  btRigidBody* still_ = nullptr;
  std::vector<std::unique_ptr<btTypedConstraint>> joints_;
  std::size_t part_ = 0;
};

enum class Method { euler, rk4 };

/// Trees without springs and torques only. What hangs on a body that is led is computed in that
/// body's axes.
class Minimal final : public EngineRun {
 public:
  Minimal(const Spelt& scene, const Tree& tree, Method method)
      : scene_(scene), tree_(tree), is_rk4_(method == Method::rk4), link_(scene.bodies.size(), -1) {
    const int count = static_cast<int>(tree.limbs.size());
    body_ = std::make_unique<btMultiBody>(count, btScalar(1), btVector3(1, 1, 1), true, false);
    body_->setBaseWorldTransform(btTransform::getIdentity());
    for (int i = 0; i < count; ++i) add(tree.limbs[static_cast<std::size_t>(i)], i);
    body_->finalizeMultiDof();
    body_->setLinearDamping(0), body_->setAngularDamping(0), body_->useRK4Integration(is_rk4_);
    body_->setCanSleep(false), body_->setHasSelfCollision(false);
    body_->setMaxCoordinateVelocity(btScalar(1e6));
    world_.addMultiBody(body_.get());
    world_.setGravity(vec(scene.gravity));
  }
  ~Minimal() override { world_.removeMultiBody(body_.get()); }

  bool advance() override {
    const double h = step_of(scene_);
    for (int part = 0; part < scene_.parts; ++part, time_ += h) {
      if (!scene_.sways.empty()) {
        const Three a = place_of(scene_.sways[0], time_ + h / 2, 2);
        world_.setGravity(vec(scene_.gravity) - vec(a));
      }
      world_.stepSimulation(btScalar(h), 0);
    }
    return true;
  }

  void read(Frame& to) override {
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> places;
    body_->forwardKinematics(rotations, places);
    Three shift{};
    if (!scene_.sways.empty()) {
      const Three now = place_of(scene_.sways[0], time_), start = place_of(scene_.sways[0], 0);
      for (std::size_t k = 0; k < 3; ++k) shift[k] = now[k] - start[k];
    }
    for (std::size_t i = 0; i < link_.size(); ++i) {
      if (link_[i] < 0) continue;
      const btVector3 x = body_->localPosToWorld(link_[i], btVector3(0, 0, 0));
      for (std::size_t k = 0; k < 3; ++k) to.bodies[i].position[k] = x[int(k)] + shift[k];
    }
  }

  std::string settings() const override {
    return is_rk4_ ? "float, multibody, useRK4Integration"
                   : "float, multibody, semi-implicit Euler";
  }

 private:
  void add(const Limb& limb, int number) {
    const Placed own = placed(scene_, limb.body), before = placed(scene_, limb.parent);
    link_[static_cast<std::size_t>(limb.body)] = number;
    const int parent = limb.parent < 0 ? -1 : link_[static_cast<std::size_t>(limb.parent)];
    const btQuaternion turn = quat(own.rotation.conjugate() * before.rotation);
    const btVector3 to_joint = vec(before.local(limb.anchor));
    const btVector3 from_joint = -vec(own.local(limb.anchor));
    const SpeltBody& b = scene_.bodies[static_cast<std::size_t>(limb.body)];
    if (limb.is_hinge)
      body_->setupRevolute(number, btScalar(b.mass), vec(b.inertia), parent, turn,
                           vec(Eigen::Vector3d(own.rotation.conjugate() * limb.axis)), to_joint,
                           from_joint, true);
    else
      body_->setupSpherical(number, btScalar(b.mass), vec(b.inertia), parent, turn, to_joint,
                            from_joint, true);
  }

  const Spelt& scene_;
  Tree tree_;
  bool is_rk4_;
  std::vector<int> link_;  // by body
  Ground ground_;
  btMultiBodyConstraintSolver solver_;
  btMultiBodyDynamicsWorld world_{&ground_.dispatcher, &ground_.pairs, &solver_,
                                  &ground_.configuration};
  std::unique_ptr<btMultiBody> body_;
  double time_ = 0;
};

std::unique_ptr<EngineRun> start(const Spelt& scene, const std::string& method, double) {
  if (method == "default") return std::make_unique<Maximal>(scene, 10);
  if (method == "50-iterations") return std::make_unique<Maximal>(scene, 50);
  if (method != "multibody" && method != "multibody-rk4") return nullptr;
  const Tree tree = tree_of(scene);
  if (!tree.closures.empty() || !scene.springs.empty() || !scene.torques.empty()) return nullptr;
  return std::make_unique<Minimal>(scene, tree,
                                   method == "multibody" ? Method::euler : Method::rk4);
}

}  // namespace

int main(int count, char** words) {
  const std::string version =
      std::to_string(BT_BULLET_VERSION / 100) + "." + std::to_string(BT_BULLET_VERSION % 100);
  return run_engine(count, words, {"bullet", version.c_str(), start});
}
