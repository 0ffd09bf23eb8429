#pragma once
/// A step of one mechanism by RATTLE, in double precision. [Andersen 1983]
///
///   q1 = q0 + h (v0 + h/2 M^-1 f0 + M^-1 J0^T l / h)    with C(q1) = 0, l >= 0 where curves may
///   lift and where limits are met
///   v1 = (q1 - q0) / h + h/2 M^-1 f1 + M^-1 J1^T m      with J1 v1 = 0
///
/// Springs, dampers and motors act at both ends of the step: soft ones by the trapezoidal rule,
/// stiff ones implicitly. Rolling constrains positions, too: in a plane, the difference of the arc
/// lengths rolled along both curves stays constant.
#include <optional>

#include "engine/solvers/planar/island.hpp"

namespace pantin::detail::planar {

/// Works on the plane's motions, and restores their initial state at the end.
class Rattle {
 public:
  Rattle(const World& world, Planar& all, Mechanism& of, Real h);

  /// Uses as few substeps as possible; false, without changes, on failure. Is repeated with drives
  /// that yield.
  bool run();

 private:
  static constexpr Real kClosed = 2e-13, kAccepted = 1e-10;  // of the size of the joints
  // Regularisation, as a fraction of a row's pivot, for redundant rows; iterations remove its
  // error.
  static constexpr Real kGives = 1e-8;
  static constexpr int kMostLooks = 4;

  bool take_step();
  bool go(int parts);
  void begin();
  void note_velocities(std::vector<Vec3>& to) const;
  void note_positions(std::vector<Vec3>& to) const;
  void place_at(const std::vector<Vec3>& positions);
  bool advance(Real to);
  void drive_others(Real time);
  void drift();
  void add_impulses();
  Real impulse_of(std::size_t row) const { return lambda_[row] / h_ + first_[row] + impulse_[row]; }

  void keep();
  Real fewest_parts();
  void drag(Real time);
  void take_places();

  // Rows.
  template <class F>
  void each_joint(F&& f) const {
    planar::each_joint(all_, of_, [&](const PlaneJoint& j) { f(j); });
  }
  void collect(RattleRows& to);
  void append_limit_rows(std::vector<Row>& rows) const;
  void soften(std::vector<Row>& rows, Real part) const;
  bool close_gaps();
  void shift(std::span<const Row> rows, std::span<const Real> by);
  bool settle();

  // Springs, motors and limits.
  void find_springs();
  void find_limits();
  bool switch_limits(int looks);
  enum class End { start, end };
  void kick(End at);
  void press(Real time, End at);
  Real grip(const FlatSpan& span) const;
  void project(std::span<const Row> hard, std::vector<Real>& impulses);
  void damp(End at, std::vector<Real>& impulses);
  enum class Which { soft, stiff };
  void relax(End at, std::vector<Real>& impulses);
  std::vector<Row>& damped_rows(std::span<const Row> rows, Real time, Which which);
  void prepare(DampedFactor& factor, std::span<const Row> rows) const;
  void solve_rates(const Factor& factor, std::span<const Row> rows, std::vector<Real>& impulses);
  bool overloads();
  bool yield_drives(StepOutcome outcome);

  // Places of curves.
  void note_starts();
  bool look_again(std::size_t curve);
  bool meets_anew();
  void restart();
  bool is_active(std::size_t curve, std::size_t place) const;
  std::optional<bool> switch_places(int& looks);

  const World& world_;
  Planar& all_;
  StepScratch& s_;
  Motions& m_;
  Mechanism& of_;
  Real h_, whole_ = h_, end_ = 0;  // s, of a substep and of the step; end of the substep
  RattleWork& work_ = of_.work;
  RattleRows &start_ = work_.start, &now_ = work_.now;
  std::vector<RattleSpring>& springs_ = work_.springs;
  std::vector<RattleLimit>& limits_ = work_.limits;
  std::vector<Real>&lambda_ = work_.lambda, &step_ = work_.step, &first_ = work_.first,
  &impulse_ = work_.impulse;
  std::vector<Vec3>&from_ = work_.from, &free_ = work_.free, &free_velocity_ = work_.free_velocity;
  std::vector<Pose>& searched_ = work_.searched;
  std::vector<std::array<Vec3, kMostPlaces>>& means_ = work_.means;
  std::vector<std::array<CurvePlace, kMostPlaces>>& places_ = work_.places;
  Real most_turn_ = 0;  // rad, of a body in a substep
  Real gives_ = 0;
  Real size_ = 1e-3;
};

}  // namespace pantin::detail::planar
