// Pinocchio: the articulated-body algorithm in minimal coordinates, its constrained dynamics where
// there are loops; Pinocchio has no integrators, so that those here are explicit ones.
#include <algorithm>
// clang-format off
#include <pinocchio/math.hpp>
namespace pinocchio {
/// In place of the second derivatives that Data holds and nothing here asks for: cubes of the number
/// of freedoms, 216 GB each for a thousand balls.
struct NoTensor {
  NoTensor() = default;
  NoTensor(Eigen::Index, Eigen::Index, Eigen::Index) {}
  void setZero() {}
};
template <typename Scalar, int Indices, int Options = 0>
using SmallTensor = std::conditional_t<Indices == 3, NoTensor, Tensor<Scalar, Indices, Options>>;
}  // namespace pinocchio
#define Tensor SmallTensor
#include <pinocchio/multibody.hpp>
#undef Tensor
// clang-format on
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/constrained-dynamics.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/config.hpp>

#include "tools/peers/engines/tree.hpp"
#include "tools/peers/pinocchio_steps.hpp"

namespace {

using namespace pantin::peers;
using Eigen::Vector3d;
using Eigen::VectorXd;

template <typename Scalar, int Options>
struct Joints : JointSet<Scalar, Options, Joints> {
  using JointModelHinge = pinocchio::JointModelRevoluteUnalignedTpl<Scalar, Options>;
  using JointDataHinge = pinocchio::JointDataRevoluteUnalignedTpl<Scalar, Options>;
  using JointModelVariant =
      boost::variant<pinocchio::JointModelSphericalTpl<Scalar, Options>, JointModelHinge>;
  using JointDataVariant =
      boost::variant<pinocchio::JointDataSphericalTpl<Scalar, Options>, JointDataHinge>;
};
using Model = pinocchio::ModelTpl<double, 0, Joints>;
using Data = pinocchio::DataTpl<double, 0, Joints>;
using Contact = pinocchio::RigidConstraintModelTpl<double, 0>;
using ContactData = pinocchio::RigidConstraintDataTpl<double, 0>;

pinocchio::SE3 axes_of(const Spelt& scene, const Limb& limb) {
  return {placed(scene, limb.body).rotation.toRotationMatrix(), limb.anchor};
}

/// Frames of joints lie at the joints and have the axes of the bodies that hang on them, so that
/// all coordinates are zero at the start.
Model build(const Spelt& scene, const Tree& tree, std::vector<pinocchio::JointIndex>& joint) {
  Model model;
  model.gravity.linear() << scene.gravity[0], scene.gravity[1], scene.gravity[2];
  joint.assign(scene.bodies.size(), 0);
  std::vector<pinocchio::SE3> frame(tree.limbs.size() + 1, pinocchio::SE3::Identity());
  for (const Limb& limb : tree.limbs) {
    const SpeltBody& b = scene.bodies[static_cast<std::size_t>(limb.body)];
    const pinocchio::JointIndex parent =
        limb.parent < 0 ? 0 : joint[static_cast<std::size_t>(limb.parent)];
    const pinocchio::SE3 own = axes_of(scene, limb), at = frame[parent].actInv(own);
    const Placed place = placed(scene, limb.body);
    const pinocchio::JointIndex now =
        limb.is_hinge
            ? model.addJoint(parent,
                             Joints<double, 0>::JointModelHinge(
                                 Vector3d(place.rotation.conjugate() * limb.axis)),
                             at, b.name)
            : model.addJoint(parent, Joints<double, 0>::JointModelSpherical(), at, b.name);
    joint[static_cast<std::size_t>(limb.body)] = now, frame[now] = own;
    model.appendBodyToJoint(
        now, pinocchio::Inertia(
                 b.mass, -place.local(limb.anchor),
                 Vector3d(b.inertia[0], b.inertia[1], b.inertia[2]).asDiagonal().toDenseMatrix()));
  }
  return model;
}

class PinocchioRun final : public EngineRun {
 public:
  PinocchioRun(const Spelt& scene, const Tree& tree, Way way, double tolerance)
      : scene_(scene),
        tree_(tree),
        way_(way),
        model_(build(scene, tree, joint_)),
        data_(model_),
        motion_(model_, 1e-3),
        tau_(VectorXd::Zero(model_.nv)),
        tolerance_(tolerance),
        gravity_(model_.gravity.linear()) {
    if (!tree.closures.empty()) close();
  }

  bool advance() override {
    const auto at = [&](double time) -> const VectorXd& { return accelerate(time); };
    if (way_ == Way::rk54) return motion_.adapt(frame_of(scene_), tolerance_, at);
    motion_.advance(way_, scene_.parts, step_of(scene_), at);
    return true;
  }

  void read(Frame& to) override {
    pinocchio::forwardKinematics(model_, data_, motion_.q);
    Vector3d shift = Vector3d::Zero();
    if (!scene_.sways.empty()) {
      const Three now = place_of(scene_.sways[0], motion_.time),
                  start = place_of(scene_.sways[0], 0);
      for (std::size_t k = 0; k < 3; ++k) shift[int(k)] = now[k] - start[k];
    }
    for (const Limb& limb : tree_.limbs)
      put(to.bodies[static_cast<std::size_t>(limb.body)],
          data_.oMi[joint_[static_cast<std::size_t>(limb.body)]].act(
              Vector3d(-placed(scene_, limb.body).local(limb.anchor))) +
              shift);
  }

  std::string settings() const override {
    return contacts_.empty() ? "double, aba" : "double, constraintDynamics, feedback 20 1/s";
  }

 private:
  const Limb& limb_of(int body) const {
    return *std::find_if(tree_.limbs.begin(), tree_.limbs.end(),
                         [&](const Limb& l) { return l.body == body; });
  }

  void close() {
    const auto in_joint = [&](int body, const Vector3d& point) {
      if (body < 0) return pinocchio::SE3(Eigen::Matrix3d::Identity(), point);
      return pinocchio::SE3(Eigen::Matrix3d::Identity(),
                            axes_of(scene_, limb_of(body)).actInv(point));
    };
    const auto joint_of = [&](int body) {
      return body < 0 ? pinocchio::JointIndex(0) : joint_[static_cast<std::size_t>(body)];
    };
    for (const Closure& c : tree_.closures) {
      contacts_.emplace_back(pinocchio::CONTACT_3D, model_, joint_of(c.a), in_joint(c.a, c.point),
                             joint_of(c.b), in_joint(c.b, c.point), pinocchio::LOCAL);
      contacts_.back().baumgarte_corrector_parameters().Kp = 400;
      contacts_.back().baumgarte_corrector_parameters().Kd = 40;
      contact_data_.emplace_back(contacts_.back());
    }
    pinocchio::initConstraintDynamics(model_, data_, contacts_, contact_data_);
  }

  /// The place of a body's joint now, and of all before it: data_ has them only after it was asked
  /// for the accelerations.
  const pinocchio::SE3& place(pinocchio::JointIndex joint) {
    for (const pinocchio::JointIndex j : model_.supports[joint]) {
      if (j == 0) continue;
      model_.joints[j].calc(data_.joints[j], motion_.q);
      data_.liMi[j] = model_.jointPlacements[j] * data_.joints[j].M();
      data_.oMi[j] = data_.oMi[model_.parents[j]] * data_.liMi[j];
    }
    return data_.oMi[joint];
  }

  /// tau_ = what springs and torques come to in the joints, from the load on a body about the
  /// world's origin on all joints that it hangs on.
  void push() {
    const auto add = [&](int body, const pinocchio::Force& load) {
      for (int i = body; i >= 0; i = limb_of(i).parent) {
        const pinocchio::JointIndex joint = joint_[static_cast<std::size_t>(i)];
        const Limb& limb = limb_of(i);
        const Vector3d torque = data_.oMi[joint].actInv(load).angular();
        if (limb.is_hinge)
          tau_[model_.idx_vs[joint]] +=
              torque.dot(placed(scene_, i).rotation.conjugate() * limb.axis);
        else
          tau_.segment<3>(model_.idx_vs[joint]) += torque;
      }
    };
    tau_.setZero();
    load(
        scene_,
        [&](int i, const Three& local) {
          Vector3d at(local[0], local[1], local[2]);
          if (i >= 0)
            at = place(joint_[static_cast<std::size_t>(i)])
                     .act(Vector3d(
                         axes_of(scene_, limb_of(i)).actInv(placed(scene_, i).point(local))));
          return Three{at[0], at[1], at[2]};
        },
        [&](int i, const Three& at, const Three& f) {
          const Vector3d force(f[0], f[1], f[2]);
          add(i, pinocchio::Force(force, Vector3d(at[0], at[1], at[2]).cross(force)));
        },
        [&](int i, const Three& t) {
          place(joint_[static_cast<std::size_t>(i)]);
          add(i, pinocchio::Force(Vector3d::Zero(), Vector3d(t[0], t[1], t[2])));
        });
  }

  const VectorXd& accelerate(double time) {
    if (!scene_.springs.empty() || !scene_.torques.empty()) push();
    if (!scene_.sways.empty()) {
      const Three a = place_of(scene_.sways[0], time, 2);
      model_.gravity.linear() = gravity_ - Vector3d(a[0], a[1], a[2]);
    }
    if (!contacts_.empty())
      return pinocchio::constraintDynamics(model_, data_, motion_.q, motion_.v, tau_, contacts_,
                                           contact_data_, proximal_);
    // A tenth quicker than the local convention on chains.
    return pinocchio::aba(model_, data_, motion_.q, motion_.v, tau_, pinocchio::Convention::WORLD);
  }

  const Spelt& scene_;
  Tree tree_;
  Way way_;
  std::vector<pinocchio::JointIndex> joint_;  // by body
  Model model_;
  Data data_;
  Motion<Model> motion_;
  VectorXd tau_;
  double tolerance_;
  Vector3d gravity_;
  PINOCCHIO_STD_VECTOR_WITH_EIGEN_ALLOCATOR(Contact) contacts_;
  PINOCCHIO_STD_VECTOR_WITH_EIGEN_ALLOCATOR(ContactData) contact_data_;
  pinocchio::ProximalSettings proximal_{1e-13, 1e-9, 10};
};

std::unique_ptr<EngineRun> start(const Spelt& scene, const std::string& method, double setting) {
  const Way way = method == "euler" ? Way::euler : method == "rk4" ? Way::rk4 : Way::rk54;
  if (way == Way::rk54 && method != "rk54") return nullptr;
  return std::make_unique<PinocchioRun>(scene, tree_of(scene), way, setting);
}

}  // namespace

int main(int count, char** words) {
  return run_engine(count, words, {"pinocchio", PINOCCHIO_VERSION, start});
}
