#pragma once
/// Data of a step by the energy-momentum method (conserving.hpp) for one island: vectorised over
/// bodies where they are independent, sequential along the joints.
#include "engine/solvers/articulated/kernels/predict.hpp"
#include "engine/solvers/articulated/kernels/rows.hpp"

namespace pantin::detail::articulated {
namespace {

/// The matrices of an elimination: renewed; those kept of an iteration before; or, in some islands
/// renewed, in others kept.
enum class Factor : std::uint8_t { renewed, kept, mixed };

/// State of a vector of bodies at the start of a step, after half its drag.
template <class F>
struct StartState {
  Vec<F> x, v, w;
  Qua<F> q;
};

/// Parents of a vector of bodies: rotations at the start and at the iterate, arms at the iterate.
template <class F>
struct ParentState {
  Qua<F> q0, q1;
  Vec<F> end_arm, mean_arm;
};

class BodyLanes {
 public:
  using Number = double;                          // along the joints
  using Wide = Four;                              // elsewhere
  static constexpr std::size_t kAtOnce = kLanes;  // bodies of an island in a vector
  static constexpr int kIslands = 1;
  static constexpr bool kHooks = true;  // may have joints that constrain rotations

  BodyLanes(const IslandView& view, const ConservingInput& input) : p(view), in(input) {}

  const IslandView& p;
  const ConservingInput& in;

  std::size_t count() const { return p.count; }
  const std::int32_t* parents() const { return p.parents; }
  double step_length() const { return in.h; }
  static INLINE Four spread(double x) { return all(x); }
  static bool is_used(int /*island*/) { return true; }
  const ConservingInput& input(int /*island*/) const { return in; }
  INLINE const double* constants(std::size_t i) const {
    return column(p.constants, kConstantRows, i);
  }
  INLINE double* work(std::size_t i) const { return column(p.work, kWorkRows, i); }
  INLINE double* memory(std::size_t i) const { return column(p.memory, kMemoryRows, i); }
  INLINE double* node(std::size_t i) const { return p.nodes + kNodeSize * i; }
  bool may_keep() const { return in.may_keep; }
  template <class Do>
  INLINE void renew(std::size_t i, Factor /*factor*/, const Do& write) const {
    write(node(i));
  }
  template <class T>
  static INLINE T renewed(Factor /*factor*/, T now, T /*before*/) {
    return now;
  }
  template <class T>
  static INLINE T kept(Factor /*factor*/, T now, T /*before*/) {
    return now;
  }
  INLINE const double* forces(std::size_t i) const {
    return p.forces ? column(p.forces, 6, i) : nullptr;
  }
  const double* targets() const { return in.targets; }
  const double* ways() const { return in.ways; }
  const double* anchor_velocities() const { return in.anchor_velocities; }

  INLINE StartState<Four> start(std::size_t i) {
    const FourBodies bodies(p, i);
    const Four keep = damping_.of(num<Four>(constants(i), kDrag));
    return {bodies.vec(p.layout.position), keep * bodies.vec(p.layout.velocity),
            keep * bodies.vec(p.layout.angular_velocity), bodies.qua(p.layout.rotation)};
  }
  INLINE Four half_drag(std::size_t i) { return damping_.of(num<Four>(constants(i), kDrag)); }
  /// Of one body: its position, and its velocity after half the drag.
  INLINE Vec<double> position(std::size_t i) const { return of_body(i, p.layout.position); }
  INLINE Vec<double> velocity(std::size_t i) const {
    return ::exp(-0.5 * in.h * num<double>(constants(i), kDrag)) * of_body(i, p.layout.velocity);
  }

  /// The parents of a block, lane by lane; roots use their own state.
  INLINE ParentState<Four> parents_of(std::size_t i, const StartState<Four>& own) const {
    const double* k = work(i);
    ParentState<Four> s{own.q, qua<Four>(k, kEndRotation), vec<Four>(k, kEndArm),
                        vec<Four>(k, kMeanArm)};
    for (std::size_t l = 0; l < kLanes; ++l) {
      const std::int32_t parent = p.parents[i + l];
      if (parent < 0) continue;
      const auto at = static_cast<std::size_t>(parent);
      const double* b = p.bodies + p.slots[at] * p.layout.stride + p.layout.rotation;
      s.q0.x[l] = b[0], s.q0.y[l] = b[1], s.q0.z[l] = b[2], s.q0.w[l] = b[3];
      const double* o = work(at);
      s.q1.x[l] = o[kEndRotation * kLanes], s.q1.y[l] = o[(kEndRotation + 1) * kLanes];
      s.q1.z[l] = o[(kEndRotation + 2) * kLanes], s.q1.w[l] = o[(kEndRotation + 3) * kLanes];
      const Vec<double> end = vec<double>(o, kEndArm), mean = vec<double>(o, kMeanArm);
      s.end_arm.x[l] = end.x, s.end_arm.y[l] = end.y, s.end_arm.z[l] = end.z;
      s.mean_arm.x[l] = mean.x, s.mean_arm.y[l] = mean.y, s.mean_arm.z[l] = mean.z;
    }
    return s;
  }

  /// A sum over the bodies, a number for each island.
  class Sum {
   public:
    INLINE void add(std::size_t /*body*/, Four v) { sum_ += v; }
    double total() const { return sum(sum_); }

   private:
    Four sum_ = all(0);
  };
  /// The largest over the bodies.
  static double largest_of(Four x) { return largest(x); }
  /// 1 for bodies, 0 for padding.
  INLINE Four mask_of(std::size_t i) const { return mask(i, p.count); }
  static double of_island(double x, int /*island*/) { return x; }
  static INLINE Four factors_of(const double (&factors)[1]) { return all(factors[0]); }

  void choose_factor(int /*island*/, Factor /*factor*/) const {}
  /// Islands whose iterations have ended keep their values.
  void stop(int /*island*/) const {}
  template <class T>
  static INLINE T running(T now, T /*before*/) {
    return now;
  }
  static INLINE Vec<Four> following(const ConservingInput& in, Vec<Four> now, Vec<Four> last) {
    return in.follows_equal_step ? now + now - last : now;
  }

  INLINE void set_bodies(std::size_t i, std::size_t at, Vec<Four> v) const {
    FourBodies(p, i).set(at, v, p.count - i < kLanes ? p.count - i : kLanes);
  }
  INLINE void set_bodies(std::size_t i, std::size_t at, Four v) const {
    FourBodies(p, i).set(at, v, p.count - i < kLanes ? p.count - i : kLanes);
  }
  void set_outcome(int /*island*/, LaneOutcome outcome) { taken_ = outcome == LaneOutcome::taken; }
  bool any_taken() const { return taken_; }

  bool has_ties() const { return in.ties; }
  INLINE const double* tie_block(std::size_t i) const { return in.ties->blocks + kTieBlock * i; }
  INLINE bool is_grounded(std::size_t i) const { return in.ties->grounded[i] != 0; }
  INLINE double* tie_factor(std::size_t i) const { return in.ties->factors + kTieFactor * i; }
  void load_ties() const { in.ties->load(in.ties->context); }
  void correct_ties(bool (&fails)[1]) const { fails[0] = !in.ties->correct(in.ties->context); }
  void settle_ties(bool (&near)[1]) const {
    near[0] = near[0] && in.ties->settled(in.ties->context);
  }
  bool accept_ties(int /*island*/, double& released) const {
    return in.ties->accept(in.ties->context, released);
  }
  bool accept_limits(int /*island*/) const {
    return !in.limits || in.limits->are_clear(in.limits->context);
  }
  void project_ties(const bool (&/*wanted*/)[1], bool (&fails)[1]) const {
    fails[0] = !in.ties->project(in.ties->context);
  }
  /// 1 if every tie connects a tree to itself, else 0.
  double inner_ties() const { return !in.ties || *in.ties->inner ? 1 : 0; }
  bool is_struck(int /*island*/) const { return in.ties && *in.ties->struck; }
  double place_work(int /*island*/) const { return in.ties ? *in.ties->place_work : 0; }

 private:
  INLINE Vec<double> of_body(std::size_t i, std::size_t at) const {
    const double* b = p.bodies + p.slots[i] * p.layout.stride + at;
    return {b[0], b[1], b[2]};
  }

  DampingFactor damping_{0.5 * in.h};
  bool taken_ = false;
};

}  // namespace
}  // namespace pantin::detail::articulated
