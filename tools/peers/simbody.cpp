// The chain in Simbody: minimal coordinates, quaternions, its own integrators.
#include <iterator>

#include "tools/peers/peer.hpp"
#include "tools/peers/simbody_steps.hpp"

namespace {

using namespace pantin::peers;
using SimTK::Vec3;

enum class Way { euler, merson };

class SimbodyRun final : public Run {
 public:
  SimbodyRun(const Chain& chain, Way way, double setting)
      : chain_(chain),
        matter_(system_),
        forces_(system_),
        gravity_(forces_, matter_, -SimTK::YAxis, chain.gravity) {
    const Vec3 half(chain.length / 2, 0, 0);
    const SimTK::Body::Rigid link(SimTK::MassProperties(
        chain.mass(), half,
        SimTK::Inertia(chain.inertia_along(), chain.inertia_across(), chain.inertia_across())
            .shiftFromMassCenter(half, chain.mass())));
    for (int i = 0; i < chain.links; ++i) {
      SimTK::MobilizedBody& before = matter_.updMobilizedBody(SimTK::MobilizedBodyIndex(i));
      SimTK::MobilizedBody::Ball(before, Vec3(i == 0 ? 0 : chain.length, 0, 0), link, Vec3(0));
    }
    start_ = system_.realizeTopology();
    system_.realizeModel(start_);
    integrator_ = way == Way::merson ? integrator_within(system_, setting)
                                     : integrator_of(system_, 1 / (kFrames * setting));
    reset();
  }

  void reset() override {
    integrator_->resetAllStatistics();
    integrator_->initialize(start_);
    frame_ = 0;
    evaluations_before_ = system_.getNumRealizationsOfThisStage(SimTK::Stage::Acceleration);
  }

  bool advance(int frames) override {
    frame_ += frames;
    const double until = double(frame_) / kFrames;
    return advance_to(*integrator_, until);
  }

  void read(LinkState* links) override {
    const SimTK::State& state = integrator_->getState();
    system_.realize(state, SimTK::Stage::Velocity);
    for (std::size_t i = 0; i < static_cast<std::size_t>(chain_.links); ++i) {
      const SimTK::MobilizedBody& b =
          matter_.getMobilizedBody(SimTK::MobilizedBodyIndex(int(i) + 1));
      const Vec3 half(chain_.length / 2, 0, 0);
      const Vec3 centre = b.findStationLocationInGround(state, half);
      const Vec3 velocity = b.findStationVelocityInGround(state, half);
      const Vec3 angular_velocity = b.getBodyAngularVelocity(state);
      const Vec3 axis = b.getBodyRotation(state) * Vec3(1, 0, 0);
      for (int k = 0; k < 3; ++k) {
        links[i].centre[k] = centre[k], links[i].axis[k] = axis[k];
        links[i].velocity[k] = velocity[k], links[i].angular_velocity[k] = angular_velocity[k];
      }
    }
  }

  Counts counts() override {
    return {
        integrator_->getNumStepsAttempted(),
        system_.getNumRealizationsOfThisStage(SimTK::Stage::Acceleration) - evaluations_before_};
  }

 private:
  Chain chain_;
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_;
  SimTK::GeneralForceSubsystem forces_;
  SimTK::Force::Gravity gravity_;
  SimTK::State start_;
  std::unique_ptr<SimTK::Integrator> integrator_;
  long frame_ = 0, evaluations_before_ = 0;
};

template <Way way>
std::unique_ptr<Run> make(const Chain& chain, double setting) {
  return std::make_unique<SimbodyRun>(chain, way, setting);
}

constexpr Method kMethods[] = {
    {"euler", false, 0, 0, 1, true, make<Way::euler>},
    {"Merson", true, 1e-1, 1e-10, 1, true, make<Way::merson>},
};
constexpr Engine kEngine{"3.7", PANTIN_PEERS_FLAGS, kMethods, std::size(kMethods)};

}  // namespace

extern "C" const Engine* pantin_peer() { return &kEngine; }
