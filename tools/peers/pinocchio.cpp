// The chain in Pinocchio: the articulated-body algorithm in minimal coordinates.
#include <algorithm>
#include <iterator>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/joint-configuration.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/config.hpp>
#include <pinocchio/multibody.hpp>
#include <string>
#include <vector>

#include "tools/peers/peer.hpp"

namespace {

using namespace pantin::peers;

/// Joints that this program knows: fewer compile sooner, and are dispatched sooner.
template <typename Scalar_, int Options_>
struct Joints {
  using Scalar = Scalar_;
  static constexpr int Options = Options_;
  using JointModelSpherical = pinocchio::JointModelSphericalTpl<Scalar, Options>;
  using JointDataSpherical = pinocchio::JointDataSphericalTpl<Scalar, Options>;
  using JointModelComposite = pinocchio::JointModelCompositeTpl<Scalar, Options, Joints>;
  using JointDataComposite = pinocchio::JointDataCompositeTpl<Scalar, Options, Joints>;
  using JointModelMimic = pinocchio::JointModelMimicTpl<Scalar, Options, Joints>;
  using JointDataMimic = pinocchio::JointDataMimicTpl<Scalar, Options, Joints>;
  using JointModelVariant = boost::variant<JointModelSpherical>;
  using JointDataVariant = boost::variant<JointDataSpherical>;
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

/// An explicit Runge-Kutta method.
struct Table {
  int stages;
  double a[7][6], b[7], lower[7];
};
constexpr Table kClassic{
    4, {{}, {0.5}, {0, 0.5}, {0, 0, 1}}, {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6}, {}};
/// [Dormand & Prince 1980]
constexpr Table kPair{
    7,
    {{},
     {1.0 / 5},
     {3.0 / 40, 9.0 / 40},
     {44.0 / 45, -56.0 / 15, 32.0 / 9},
     {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
     {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
     {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}},
    {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84, 0},
    {5179.0 / 57600, 0, 7571.0 / 16695, 393.0 / 640, -92097.0 / 339200, 187.0 / 2100, 1.0 / 40}};

enum class Way { euler, rk4, rk54 };

class PinocchioRun final : public Run {
 public:
  PinocchioRun(const Chain& chain, Way way, double setting)
      : chain_(chain),
        way_(way),
        model_(build(chain)),
        data_(model_),
        tolerance_(way == Way::rk54 ? setting : 0),
        steps_in_frame_(way == Way::rk54 ? 1 : static_cast<int>(setting)) {
    for (VectorXd* x : {&v_, &from_v_, &turn_, &tau_}) x->setZero(model_.nv);
    for (VectorXd& x : turn_rate_) x.setZero(model_.nv);
    for (VectorXd& x : rate_) x.setZero(model_.nv);
    reset();
  }

  void reset() override {
    q_ = from_q_ = next_q_ = pinocchio::neutral(model_);
    v_.setZero();
    try_ = 1.0 / (16 * kFrames);
    counts_ = {};
  }

  bool advance(int frames) override {
    if (way_ == Way::rk54) return adapt(double(frames) / kFrames);
    const long steps = long{frames} * steps_in_frame_;
    const double h = 1.0 / (kFrames * steps_in_frame_);
    counts_.steps += steps;
    for (long i = 0; i < steps; ++i)
      if (way_ == Way::euler)
        euler(h);
      else
        q_.swap(from_q_), v_.swap(from_v_), runge_kutta(kClassic, h);
    return true;
  }

  void read(LinkState* links) override {
    pinocchio::forwardKinematics(model_, data_, q_, v_);
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

  Counts counts() override { return counts_; }

 private:
  const VectorXd& accelerate() {
    ++counts_.evaluations;
    // A tenth quicker than the local convention on chains.
    return pinocchio::aba(model_, data_, q_, v_, tau_, pinocchio::Convention::WORLD);
  }

  void euler(double h) {
    v_.noalias() += h * accelerate();
    turn_.noalias() = h * v_;
    pinocchio::integrate(model_, q_, turn_, next_q_);
    q_.swap(next_q_);
  }

  /// The rate of the rotation vector `turn_` since the start of the step, whose end spins at `v_`
  /// in its own axes: exact to the fifth order. [Munthe-Kaas 1999]
  void turn_rates(VectorXd& rates) {
    for (Eigen::Index i = 0; i < v_.size(); i += 3) {
      const Vector3d u = turn_.segment<3>(i), w = v_.segment<3>(i), across = u.cross(w);
      rates.segment<3>(i) = w + 0.5 * across + u.cross(across) / 12;
    }
  }

  /// q_, v_ = from_q_, from_v_ and `h` times the weighted rates.
  void combine(const double* weights, int count, double h) {
    turn_.setZero();
    v_ = from_v_;
    for (int j = 0; j < count; ++j) {
      if (weights[j] == 0) continue;
      turn_.noalias() += h * weights[j] * turn_rate_[j];
      v_.noalias() += h * weights[j] * rate_[j];
    }
    pinocchio::integrate(model_, from_q_, turn_, q_);
  }

  /// One step from from_q_, from_v_ to q_, v_.
  void runge_kutta(const Table& t, double h) {
    for (int i = 0; i < t.stages; ++i) {
      if (i == 0)
        q_ = from_q_, v_ = from_v_, turn_.setZero();
      else
        combine(t.a[i], i, h);
      rate_[i] = accelerate();
      turn_rates(turn_rate_[i]);
    }
    combine(t.b, t.stages, h);
  }

  /// The worst estimated error of a step, rad or rad/s, of any joint.
  double error(double h) const {
    double worst = 0;
    for (Eigen::Index i = 0; i < v_.size(); i += 3) {
      Vector3d turn(0, 0, 0), v(0, 0, 0);
      for (int j = 0; j < kPair.stages; ++j) {
        const double weight = h * (kPair.b[j] - kPair.lower[j]);
        turn += weight * turn_rate_[j].segment<3>(i), v += weight * rate_[j].segment<3>(i);
      }
      worst = std::max({worst, turn.norm(), v.norm()});
    }
    return worst;
  }

  bool adapt(double span) {
    double done = 0, h = std::min(try_, span);
    while (done < span * (1 - 1e-12)) {
      if (h < 1e-12) return false;
      const bool last = done + h > span * (1 - 1e-12);
      const double now = last ? span - done : h;
      from_q_ = q_, from_v_ = v_;
      runge_kutta(kPair, now);
      ++counts_.steps;
      const double e = error(now);
      const double factor =
          std::isfinite(e) ? 0.9 * std::pow(tolerance_ / std::max(e, 1e-300), 0.2) : 0.1;
      if (e <= tolerance_) {
        done += now;
        if (!last || factor < 1) h = now * std::clamp(factor, 0.2, 5.0);
      } else {
        q_ = from_q_, v_ = from_v_;
        h = now * std::clamp(factor, 0.1, 0.7);
      }
    }
    try_ = h;
    return true;
  }

  Chain chain_;
  Way way_;
  Model model_;
  Data data_;
  double tolerance_, try_ = 0;
  int steps_in_frame_;
  VectorXd q_, v_, from_q_, from_v_, next_q_, turn_, tau_;
  VectorXd turn_rate_[7], rate_[7];
  Counts counts_;
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
