// The chain in Pinocchio: the articulated-body algorithm in minimal coordinates.
#include <iterator>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/config.hpp>
#include <string>

#include "tools/peers/peer.hpp"
#include "tools/peers/pinocchio_steps.hpp"

namespace {

using namespace pantin::peers;

template <typename Scalar, int Options>
struct Joints : JointSet<Scalar, Options, Joints> {
  using JointModelVariant = boost::variant<pinocchio::JointModelSphericalTpl<Scalar, Options>>;
  using JointDataVariant = boost::variant<pinocchio::JointDataSphericalTpl<Scalar, Options>>;
};
using Model = pinocchio::ModelTpl<double, 0, Joints>;
using Data = pinocchio::DataTpl<double, 0, Joints>;
using Eigen::Vector3d;
using Eigen::VectorXd;

Model build(const Chain& chain) {
  Model model;
  model.gravity.linear() << 0, -chain.gravity, 0;
  Vector3d inertia(chain.inertia_along(), chain.inertia_across(), chain.inertia_across());
  const pinocchio::Inertia link(chain.mass(), Vector3d(chain.length / 2, 0, 0),
                                inertia.asDiagonal().toDenseMatrix());
  pinocchio::JointIndex before = 0;
  for (int i = 0; i < chain.links; ++i) {
    pinocchio::SE3 at = pinocchio::SE3::Identity();
    if (i > 0) at.translation() << chain.length, 0, 0;
    before = model.addJoint(before, Joints<double, 0>::JointModelSpherical(), at,
                            "ball" + std::to_string(i));
    model.appendBodyToJoint(before, link);
  }
  return model;
}

class PinocchioRun final : public Run {
 public:
  PinocchioRun(const Chain& chain, Way way, double setting)
      : chain_(chain),
        way_(way),
        model_(build(chain)),
        data_(model_),
        motion_(model_, 1.0 / (16 * kFrames)),
        tau_(VectorXd::Zero(model_.nv)),
        tolerance_(way == Way::rk54 ? setting : 0),
        steps_in_frame_(way == Way::rk54 ? 1 : static_cast<int>(setting)) {}

  void reset() override { motion_.reset(), evaluations_ = 0; }

  bool advance(int frames) override {
    const auto accelerate = [&](double) -> const VectorXd& {
      ++evaluations_;
      // A tenth quicker than the local convention on chains.
      return pinocchio::aba(model_, data_, motion_.q, motion_.v, tau_,
                            pinocchio::Convention::WORLD);
    };
    if (way_ == Way::rk54) return motion_.adapt(double(frames) / kFrames, tolerance_, accelerate);
    motion_.advance(way_, long{frames} * steps_in_frame_, 1.0 / (kFrames * steps_in_frame_),
                    accelerate);
    return true;
  }

  void read(LinkState* links) override {
    pinocchio::forwardKinematics(model_, data_, motion_.q, motion_.v);
    for (std::size_t i = 0; i < static_cast<std::size_t>(chain_.links); ++i) {
      const pinocchio::SE3& at = data_.oMi[i + 1];
      const pinocchio::Motion& motion = data_.v[i + 1];  // in the link's axes, at its joint
      const Vector3d arm(chain_.length / 2, 0, 0);
      const Vector3d centre = at.act(arm), axis = at.rotation().col(0);
      const Vector3d velocity = at.rotation() * (motion.linear() + motion.angular().cross(arm));
      const Vector3d angular_velocity = at.rotation() * motion.angular();
      for (int k = 0; k < 3; ++k) {
        links[i].centre[k] = centre[k], links[i].axis[k] = axis[k];
        links[i].velocity[k] = velocity[k], links[i].angular_velocity[k] = angular_velocity[k];
      }
    }
  }

  Counts counts() override { return {motion_.steps, evaluations_}; }

 private:
  Chain chain_;
  Way way_;
  Model model_;
  Data data_;
  Motion<Model> motion_;
  VectorXd tau_;
  double tolerance_;
  int steps_in_frame_;
  long evaluations_ = 0;
};

template <Way way>
std::unique_ptr<Run> make(const Chain& chain, double setting) {
  return std::make_unique<PinocchioRun>(chain, way, setting);
}

constexpr Method kMethods[] = {
    {"euler", false, 0, 0, 1, true, make<Way::euler>},
    {"rk4", false, 0, 0, 1, true, make<Way::rk4>},
    {"rk54", true, 1e-1, 1e-10, 1, true, make<Way::rk54>},
};
constexpr Engine kEngine{PINOCCHIO_VERSION, PANTIN_PEERS_FLAGS, kMethods, std::size(kMethods)};

}  // namespace

extern "C" const Engine* pantin_peer() { return &kEngine; }
