// Simbody: minimal coordinates, constraints for loops, its own integrators.
#include "tools/peers/engines/tree.hpp"
#include "tools/peers/simbody_steps.hpp"

namespace {

using namespace pantin::peers;
using SimTK::Rotation;
using SimTK::Transform;
using SimTK::Vec3;

Vec3 vec(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Vec3 vec(const Three& v) { return {v[0], v[1], v[2]}; }
Rotation turn(const Eigen::Quaterniond& q) {
  return Rotation(SimTK::Quaternion(q.w(), q.x(), q.y(), q.z()));
}

class SimbodyRun final : public EngineRun {
 public:
  SimbodyRun(const Spelt& scene, const Tree& tree, double accuracy)
      : scene_(scene),
        tree_(tree),
        accuracy_(accuracy),
        matter_(system_),
        forces_(system_),
        gravity_(forces_, matter_, Vec3(scene.gravity[0], scene.gravity[1], scene.gravity[2])),
        index_(scene.bodies.size()) {
    matter_.setShowDefaultGeometry(false);
    ground_ = matter_.Ground().getMobilizedBodyIndex();
    if (!scene.sways.empty()) lead();
    for (const Limb& limb : tree.limbs) hang(limb);
    for (const Closure& c : tree.closures)
      SimTK::Constraint::Ball(body(c.a), vec(local(c.a, c.point)), body(c.b),
                              vec(local(c.b, c.point)));
    const auto end = [&](int i) { return i < 0 ? matter_.Ground() : body(i); };
    for (const SpeltSpring& s : scene.springs)
      SimTK::Force::TwoPointLinearSpring(forces_, end(s.a), vec(s.anchor_a), end(s.b),
                                         vec(s.anchor_b), s.stiffness, s.length);
    for (const SpeltTorque& t : scene.torques)
      SimTK::Force::ConstantTorque(forces_, body(t.body), vec(t.torque));
    SimTK::State state = system_.realizeTopology();
    system_.realizeModel(state);
    integrator_ = accuracy > 0 ? integrator_within(system_, accuracy)
                               : integrator_of(system_, step_of(scene));
    integrator_->initialize(state);
  }

  bool advance() override {
    const double until = ++frame_ * frame_of(scene_);
    return advance_to(*integrator_, until);
  }

  void read(Frame& to) override {
    const SimTK::State& state = integrator_->getState();
    system_.realize(state, SimTK::Stage::Position);
    for (const Limb& limb : tree_.limbs) {
      const Vec3 x = body(limb.body).getBodyOriginLocation(state);
      put(to.bodies[static_cast<std::size_t>(limb.body)], {x[0], x[1], x[2]});
    }
  }

  std::string settings() const override {
    return accuracy_ > 0 ? "double, Runge-Kutta-Merson, accuracy as given"
                         : "double, SemiExplicitEuler";
  }

 private:
  SimTK::MobilizedBody& body(int i) {
    return matter_.updMobilizedBody(i < 0 ? ground_ : index_[static_cast<std::size_t>(i)]);
  }

  /// A point of the start, in world axes, in those of the body. What stands for the world where a
  /// body is led has the world's axes and that body's place.
  Eigen::Vector3d local(int i, const Eigen::Vector3d& point) const {
    if (i >= 0 || tree_.led < 0) return placed(scene_, i).local(point);
    return point - placed(scene_, tree_.led).position;
  }

  /// A slider along x that follows the path.
  void lead() {
    const SpeltSway& s = scene_.sways[0];
    const SimTK::Body::Massless none;
    SimTK::MobilizedBody::Slider slider(matter_.Ground(),
                                        Transform(Vec3(s.centre[0], s.centre[1], s.centre[2])),
                                        none, Transform());
    SimTK::Motion::Sinusoid(slider, SimTK::Motion::Position, s.amplitude[0],
                            2 * SimTK::Pi * s.frequency[0], s.phase[0]);
    ground_ = slider.getMobilizedBodyIndex();
  }

  void hang(const Limb& limb) {
    const SpeltBody& b = scene_.bodies[static_cast<std::size_t>(limb.body)];
    const Placed own = placed(scene_, limb.body);
    const Eigen::Quaterniond before =
        limb.parent < 0 ? Eigen::Quaterniond::Identity() : placed(scene_, limb.parent).rotation;
    // The frames of a pin turn about z.
    Eigen::Quaterniond frame = own.rotation;
    if (limb.is_hinge)
      frame = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), limb.axis);
    const Transform in_parent(turn(before.conjugate() * frame),
                              vec(local(limb.parent, limb.anchor)));
    const Transform in_body(turn(own.rotation.conjugate() * frame), vec(own.local(limb.anchor)));
    const SimTK::Body::Rigid rigid(SimTK::MassProperties(
        b.mass, Vec3(0), SimTK::Inertia(b.inertia[0], b.inertia[1], b.inertia[2])));
    SimTK::MobilizedBody& parent = body(limb.parent);
    index_[static_cast<std::size_t>(limb.body)] =
        limb.is_hinge
            ? SimTK::MobilizedBody::Pin(parent, in_parent, rigid, in_body).getMobilizedBodyIndex()
            : SimTK::MobilizedBody::Ball(parent, in_parent, rigid, in_body).getMobilizedBodyIndex();
  }

  const Spelt& scene_;
  Tree tree_;
  double accuracy_;
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_;
  SimTK::GeneralForceSubsystem forces_;
  SimTK::Force::Gravity gravity_;
  SimTK::MobilizedBodyIndex ground_;
  std::vector<SimTK::MobilizedBodyIndex> index_;
  std::unique_ptr<SimTK::Integrator> integrator_;
  long frame_ = 0;
};

std::unique_ptr<EngineRun> start(const Spelt& scene, const std::string& method, double setting) {
  if (method != "merson" && method != "semi-explicit-euler") return nullptr;
  for (const SpeltSway& s : scene.sways)
    if (s.amplitude[1] != 0 || s.amplitude[2] != 0) return nullptr;
  return std::make_unique<SimbodyRun>(scene, tree_of(scene), method == "merson" ? setting : 0);
}

}  // namespace

int main(int count, char** words) {
  return run_engine(count, words, {"simbody", PANTIN_PEERS_VERSION, start});
}
