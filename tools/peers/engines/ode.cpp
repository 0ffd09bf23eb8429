// Open Dynamics Engine: bodies with a direct or an iterated solver of the constraints of a step.
#include <ode/ode.h>

#include "tools/peers/engines/engine.hpp"

namespace {

using namespace pantin::peers;

enum class Solver { quick, direct };

class OdeRun final : public EngineRun {
 public:
  OdeRun(const Spelt& scene, Solver solver, int iterations)
      : scene_(scene), is_direct_(solver == Solver::direct), iterations_(iterations) {
    dInitODE();
    world_ = dWorldCreate();
    dWorldSetGravity(world_, scene.gravity[0], scene.gravity[1], scene.gravity[2]);
    dWorldSetQuickStepNumIterations(world_, iterations);
    for (const SpeltBody& b : scene.bodies) add(b);
    for (const SpeltJoint& j : scene.joints) join(j);
  }
  ~OdeRun() override { dWorldDestroy(world_), dCloseODE(); }

  bool advance() override {
    const double h = step_of(scene_);
    for (int part = 0; part < scene_.parts; ++part, ++part_) {
      for (std::size_t i = 0; i < bodies_.size(); ++i) lead(i, h);
      push();
      if (!(is_direct_ ? dWorldStep(world_, h) : dWorldQuickStep(world_, h))) return false;
    }
    return true;
  }

  void read(Frame& to) override {
    for (std::size_t i = 0; i < bodies_.size(); ++i)
      for (int k = 0; k < 3; ++k) to.bodies[i].position[k] = dBodyGetPosition(bodies_[i])[k];
  }

  std::string settings() const override {
    return is_direct_
               ? "double, dWorldStep, ERP 0.2"
               : "double, dWorldQuickStep, " + std::to_string(iterations_) + " iterations, ERP 0.2";
  }

 private:
  void add(const SpeltBody& b) {
    const dBodyID body = dBodyCreate(world_);
    bodies_.push_back(body);
    const Three& x = b.at.position;
    const Four& q = b.at.rotation;
    const dQuaternion turn = {q[3], q[0], q[1], q[2]};
    dBodySetPosition(body, x[0], x[1], x[2]), dBodySetQuaternion(body, turn);
    if (b.motion != "dynamic") return dBodySetKinematic(body);
    dMass mass;
    dMassSetParameters(&mass, b.mass, 0, 0, 0, b.inertia[0], b.inertia[1], b.inertia[2], 0, 0, 0);
    dBodySetMass(body, &mass);
    dBodySetMaxAngularSpeed(body, dInfinity);
  }

  void join(const SpeltJoint& j) {
    const auto body = [&](int i) { return i < 0 ? nullptr : bodies_[static_cast<std::size_t>(i)]; };
    dVector3 anchor, axis;
    const dQuaternion axes = {j.axes_a[3], j.axes_a[0], j.axes_a[1], j.axes_a[2]};
    dMatrix3 turn;
    dQtoR(axes, turn);
    for (int k = 0; k < 3; ++k)
      anchor[k] = j.anchor_a[static_cast<std::size_t>(k)], axis[k] = turn[4 * k];
    if (const dBodyID a = body(j.a)) {
      const dVector3 p = {anchor[0], anchor[1], anchor[2]}, x = {axis[0], axis[1], axis[2]};
      dBodyGetRelPointPos(a, p[0], p[1], p[2], anchor);
      dBodyVectorToWorld(a, x[0], x[1], x[2], axis);
    }
    if (j.kind == "hinge") {
      const dJointID joint = dJointCreateHinge(world_, nullptr);
      dJointAttach(joint, body(j.a), body(j.b));
      dJointSetHingeAnchor(joint, anchor[0], anchor[1], anchor[2]);
      dJointSetHingeAxis(joint, axis[0], axis[1], axis[2]);
    } else {
      const dJointID joint = dJointCreateBall(world_, nullptr);
      dJointAttach(joint, body(j.a), body(j.b));
      dJointSetBallAnchor(joint, anchor[0], anchor[1], anchor[2]);
    }
  }

  /// A body on a path starts every step at its place there, with the speed that leads to the next.
  void lead(std::size_t i, double h) {
    const std::vector<SpeltPose>& path = scene_.bodies[i].path;
    if (part_ >= path.size()) return;
    const Three& from = (part_ == 0 ? scene_.bodies[i].at : path[part_ - 1]).position;
    const Three& next = path[part_].position;
    dBodySetPosition(bodies_[i], from[0], from[1], from[2]);
    dBodySetLinearVel(bodies_[i], (next[0] - from[0]) / h, (next[1] - from[1]) / h,
                      (next[2] - from[2]) / h);
  }

  void push() {
    const auto body = [&](int i) { return i < 0 ? nullptr : bodies_[static_cast<std::size_t>(i)]; };
    load(
        scene_,
        [&](int i, const Three& p) {
          dVector3 at = {p[0], p[1], p[2]};
          if (body(i)) dBodyGetRelPointPos(body(i), p[0], p[1], p[2], at);
          return Three{at[0], at[1], at[2]};
        },
        [&](int i, const Three& at, const Three& f) {
          if (body(i)) dBodyAddForceAtPos(body(i), f[0], f[1], f[2], at[0], at[1], at[2]);
        },
        [&](int i, const Three& t) { dBodyAddTorque(body(i), t[0], t[1], t[2]); });
  }

  const Spelt& scene_;
  bool is_direct_;
  int iterations_;
  dWorldID world_ = nullptr;
  std::vector<dBodyID> bodies_;
  std::size_t part_ = 0;
};

std::unique_ptr<EngineRun> start(const Spelt& scene, const std::string& method, double) {
  constexpr int kDefault = 20;
  if (method == "default") return std::make_unique<OdeRun>(scene, Solver::quick, kDefault);
  if (method == "100-iterations") return std::make_unique<OdeRun>(scene, Solver::quick, 100);
  if (method == "direct") return std::make_unique<OdeRun>(scene, Solver::direct, kDefault);
  return nullptr;
}

}  // namespace

int main(int count, char** words) {
  return run_engine(count, words, {"ode", PANTIN_PEERS_VERSION, start});
}
