// Mechanisms of curves: RATTLE in double precision. [Andersen 1983]
//
//   q1 = q0 + h (v0 + h/2 M^-1 f0 + M^-1 J0^T l / h)    with C(q1) = 0, l >= 0 where curves may
//   lift v1 = (q1 - q0) / h + h/2 M^-1 f1 + M^-1 J1^T m      with J1 v1 = 0
//
// What is damped or driven acts once, at the end, implicitly. Rolling is a row of positions, too:
// in a plane, the ways gone along both curves differ by what they did where they met.
#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/base/disjoint_sets.hpp"
#include "engine/solvers/planar/island.hpp"

namespace pantin::detail::planar {
namespace {

constexpr int kMostIterations = 40, kMostLooks = 4, kMostParts = 64;
constexpr Real kMostTurn = 0.5;                     // rad, of a body in a part of a step
constexpr Real kClosed = 1e-12, kAccepted = 1e-10;  // of the size of the joints
// Of a row's own pivot, added to it: rows that say the same give way to one another, and the rounds
// make good for it. Where curves roll about fixed axes the gap follows from rolling, and from the
// axes alone where the common normal meets both.
constexpr Real kGives = 1e-8, kGivesRolling = 1e-5;
constexpr Real kFalls = 0.25;     // a residual that falls by less: the matrix is made anew
constexpr Real kStiffest = 0.25;  // of h^2 k / m: a spring that is stiffer acts implicitly

/// A step of one mechanism; the plane's motions are its workplace.
class Rattle {
 public:
  Rattle(const World& world, Planar& all, Mechanism& of, Real h)
      : world_(world), all_(all), s_(all.scratch), m_(all.scratch.motions), of_(of), h_(h) {}

  /// In as few parts as it takes.
  bool run();

 private:
  bool go(int parts);
  void begin();
  void note_positions(std::vector<Vec3>& to) const;
  void place_at(const std::vector<Vec3>& positions);
  bool advance(Real to);
  void add_impulses();
  void note_starts();
  bool look_again(std::size_t curve);
  bool meets_anew();
  void restart();
  int fewest_parts() const;
  const PlaneJoint* joint_of_link(std::uint32_t link) const {
    const std::uint32_t at = s_.joint_of[link];
    return at == kNobody ? nullptr : &s_.plane.joints[at];
  }
  template <class F>
  void each_joint(F&& f) const {
    for (const std::uint32_t link : of_.links)
      if (const PlaneJoint* joint = joint_of_link(link)) f(*joint);
    const std::size_t pins = s_.plane.joints.size() - all_.pins.size();
    for (const std::uint32_t pin : of_.pins) f(s_.plane.joints[pins + pin]);
  }
  void collect(RattleRows& to);
  void soften(std::vector<Row>& rows, Real part) const;
  void find_springs();
  void kick(Real part);
  bool is_active(std::size_t curve, std::size_t place) const;
  std::optional<bool> switch_places(int& looks);
  bool close_gaps();
  bool within_limits() const;
  void project();
  void shift(std::span<const Row> rows, std::span<const Real> by);
  void keep();

  const World& world_;
  Planar& all_;
  StepScratch& s_;
  Motions& m_;
  Mechanism& of_;
  Real h_, whole_ = h_;  // s, of a part and of the step
  RattleWork& work_ = of_.work;
  RattleRows &start_ = work_.start, &now_ = work_.now;
  std::vector<RattleSpring>& springs_ = work_.springs;
  std::vector<Real>&lambda_ = work_.lambda, &step_ = work_.step, &impulse_ = work_.impulse;
  std::vector<Vec3>&from_ = work_.from, &free_ = work_.free;
  std::vector<Pose>& searched_ = work_.searched;
  std::vector<std::array<Vec3, kMostPlaces>>& means_ = work_.means;
  std::vector<std::array<CurvePlace, kMostPlaces>>& places_ = work_.places;
  Real gives_ = kGives;
  Real size_ = 1e-3;
};

void Rattle::collect(RattleRows& to) {
  to.rows.clear(), to.nows.clear();
  each_joint([&](const PlaneJoint& j) { append_joint_rows(j, m_, to.rows); });
  for (const std::uint32_t gear : of_.gears)
    to.rows.push_back(gear_row(world_, all_, all_.gears[gear]));
  to.first_curve = to.rows.size();
  for (std::size_t i = 0; i < of_.curves.size(); ++i) {
    const FlatCurve& c = all_.curves[of_.curves[i]];
    for (std::size_t k = 0; k < c.most_places(); ++k) {
      CurvePlace& place = places_[i][k];
      PlaceNow& now = to.nows.emplace_back();
      if (place.used && !c.over) {
        now = follow(c, place, m_);
        if (now.status == nurbs::ContactStatus::found)
          place = now.place;
        else if (!is_active(i, k))
          place.used = false;
      }
      const bool holds = now.status == nurbs::ContactStatus::found && is_active(i, k);
      append_place_rows(c, holds ? &now : nullptr, to.rows);
    }
  }
}

bool Rattle::is_active(std::size_t curve, std::size_t place) const {
  const FlatCurve& c = all_.curves[of_.curves[curve]];
  const CurvePlace& p = places_[curve][place];
  return p.used && !c.over && (!c.lifts || p.presses);
}

void Rattle::find_springs() {
  each_joint([&](const PlaneJoint& j) {
    const PlaneSpring& along = j.along;
    if (along.stiffness == 0 && along.damping == 0 && along.load == 0) return;
    RattleSpring& made = springs_.emplace_back(RattleSpring{&j});
    const Row start = sprung_row(j, m_);
    Real light = 0;
    for (int i = 0; i < start.count; ++i)
      light += glm::dot(start.j[i] * m_.inverse_mass[start.body[i]], start.j[i]);
    const bool is_soft = h_ * h_ * along.stiffness * light < kStiffest;
    made.is_explicit = along.damping == 0 && is_soft;
    made.damping = along.damping + (is_soft ? 0 : h_ * along.stiffness);
  });
}

/// Forces of positions act for a part of the step.
void Rattle::kick(Real part) {
  for (const std::uint32_t b : of_.bodies) {
    const PlaneBody& body = s_.plane.bodies[b];
    const Vec3 force = body.force + body.gravity_scale * body.mass * s_.plane.gravity;
    m_.velocity[b] += part * h_ * m_.inverse_mass[b] * Vec3(force.x, force.y, body.torque);
  }
  for (const RattleSpring& spring : springs_) {
    if (!spring.is_explicit) continue;
    const Row row = sprung_row(*spring.joint, m_);
    const Real force = spring.joint->along.load - spring.joint->along.stiffness * row.c;
    const Real by = part * h_ * force;
    for (int i = 0; i < row.count; ++i)
      m_.velocity[row.body[i]] += m_.inverse_mass[row.body[i]] * (by * row.j[i]);
  }
}

void Rattle::shift(std::span<const Row> rows, std::span<const Real> by) {
  for (std::size_t r = 0; r < rows.size(); ++r)
    for (int i = 0; i < rows[r].count; ++i) {
      const std::uint32_t b = rows[r].body[i];
      const Vec3 moved = m_.inverse_mass[b] * (by[r] * rows[r].j[i]);
      m_.position[b] += moved, m_.gained[b] += moved.z;
    }
}

void Rattle::soften(std::vector<Row>& rows, Real part) const {
  for (Row& row : rows) {
    Real own = 0;
    for (int i = 0; i < row.count; ++i)
      own += glm::dot(row.j[i] * m_.inverse_mass[row.body[i]], row.j[i]);
    row.soft = part * own;
  }
}

/// Where a curve that may lift touches now; false if nowhere near.
bool Rattle::look_again(std::size_t curve) {
  const FlatCurve& c = all_.curves[of_.curves[curve]];
  FlatCurve looked = c;
  looked.places = places_[curve], looked.known = true;
  looked.searched.position = Vec3(1e300, 0, 0);
  search_places(looked, m_);
  places_[curve] = looked.places, searched_[curve] = looked.searched;
  bool any = false;
  for (CurvePlace& place : places_[curve]) {
    if (!place.used) continue;
    const PlaceNow now = follow(c, place, m_);
    if (now.status != nurbs::ContactStatus::found) {
      place.used = false;
      continue;
    }
    any = true, place.presses = place.presses || now.gap < 0;
  }
  return any;
}

/// Whether a curve overlaps another where nothing was known of it when the step began, as when a
/// box tips over an edge.
bool Rattle::meets_anew() {
  bool any = false;
  for (std::size_t i = 0; i < of_.curves.size(); ++i) {
    const FlatCurve& c = all_.curves[of_.curves[i]];
    const bool lies = std::any_of(places_[i].begin(), places_[i].end(),
                                  [](const CurvePlace& p) { return p.used && p.lies; });
    if (!c.lifts || c.over || !(lies || is_search_due(c, searched_[i], m_))) continue;
    const auto before = places_[i];
    if (!look_again(i)) {
      places_[i] = before;
      continue;
    }
    for (std::size_t k = 0; k < kMostPlaces; ++k)
      any = any || (places_[i][k].presses && follow(c, places_[i][k], m_).gap < -kAccepted * size_);
  }
  return any;
}

/// From the free motion again, along the rows that act now. A place that is none where the step
/// begins, as the far corner of a box that tips over, takes the row that it has at the end.
void Rattle::restart() {
  place_at(from_);
  work_.kept = places_;
  collect(start_);
  places_ = work_.kept;
  place_at(free_);
  collect(now_);
  std::size_t row = start_.first_curve, at = 0;
  for (std::size_t i = 0; i < of_.curves.size(); ++i) {
    const FlatCurve& c = all_.curves[of_.curves[i]];
    for (std::size_t k = 0; k < c.most_places(); ++k, ++at, row += c.rows_per_place())
      if (is_active(i, k) && start_.nows[at].status != nurbs::ContactStatus::found)
        for (std::size_t r = row; r < row + c.rows_per_place(); ++r) start_.rows[r] = now_.rows[r];
  }
  soften(start_.rows, gives_);
  of_.positions.compute(start_.rows, m_.inverse_mass);
  lambda_.assign(start_.rows.size(), 0);
}

/// Which curves press, after a round; nothing if the step cannot be taken.
std::optional<bool> Rattle::switch_places(int& looks) {
  bool changed = false;
  std::size_t row = now_.first_curve, at = 0;
  for (std::size_t i = 0; i < of_.curves.size(); ++i) {
    const FlatCurve& c = all_.curves[of_.curves[i]];
    bool look = false;
    for (std::size_t k = 0; k < c.most_places(); ++k, ++at, row += c.rows_per_place()) {
      const PlaceNow& now = now_.nows[at];
      const bool active = is_active(i, k), found = now.status == nurbs::ContactStatus::found;
      if (active && !found && !c.lifts) return std::nullopt;
      if (!c.lifts) continue;
      CurvePlace& place = places_[i][k];
      if (active && !found) {
        place = {}, look = true;
        continue;
      }
      if (!found) continue;
      const bool pulls = active && lambda_[row] < 0 && std::abs(now.gap) < kAccepted * size_;
      const bool overlaps = !active && now.gap < -kClosed * size_ && looks >= 0;
      if (pulls) place.presses = false, changed = true;
      if (overlaps) place.presses = true, place.slip = 0, changed = true;
    }
    if (!look) continue;
    if (++looks > kMostLooks || !look_again(i)) return std::nullopt;
    changed = true;
  }
  return changed;
}

/// Positions along the rows of the start.
bool Rattle::close_gaps() {
  bool rolls = false;
  for (const std::uint32_t curve : of_.curves) rolls = rolls || all_.curves[curve].rolls;
  gives_ = rolls ? kGivesRolling : kGives;
  lambda_.assign(start_.rows.size(), 0);
  soften(start_.rows, gives_);
  of_.positions.compute(start_.rows, m_.inverse_mass);
  Real before = 1e300;
  int looks = 0;
  for (int n = 0; n < kMostIterations; ++n) {
    collect(now_);
    if (n == kMostIterations / 2) looks = -kMostIterations;  // no more are added
    const std::optional<bool> changed = switch_places(looks);
    if (!changed) return false;
    if (*changed) {
      restart(), before = 1e300;
      continue;
    }
    Real worst = 0;
    step_.clear();
    for (const Row& r : now_.rows) worst = std::max(worst, std::abs(r.c)), step_.push_back(-r.c);
    const bool stays = !(worst < 0.9 * before) && worst <= kAccepted * size_;
    of_.residual = worst;
    if (worst <= kClosed * size_ || stays) {
      if (looks < 0 || !meets_anew()) return true;
      ++looks, restart(), before = 1e300;
      continue;
    }
    if (!std::isfinite(worst)) return false;
    if (!(worst < kFalls * before) && n > 2) {
      soften(now_.rows, gives_);
      of_.positions.compute(now_.rows, m_.inverse_mass);
    }
    before = worst;
    of_.positions.solve(step_);
    for (std::size_t r = 0; r < step_.size(); ++r) lambda_[r] += step_[r];
    shift(start_.rows, step_);
  }
  return false;
}

bool Rattle::within_limits() const {
  bool fits = true;
  each_joint([&](const PlaneJoint& j) {
    if (!j.limited) return;
    const Real x = sprung_row(j, m_).c;
    fits = fits && x > j.low && x < j.high;
  });
  return fits;
}

/// Velocities along the rows of the end, dampers and motors among them.
void Rattle::project() {
  std::vector<Row>& rows = now_.rows;
  const std::size_t hard = rows.size();
  soften(rows, kGives);
  step_.assign(rows.size(), 0);
  for (const RattleSpring& spring : springs_) {
    if (spring.is_explicit) continue;
    const PlaneSpring& along = spring.joint->along;
    Row row = sprung_row(*spring.joint, m_);
    const Real force = along.load - along.stiffness * row.c;
    if (!(spring.damping > 0)) {
      for (int i = 0; i < row.count; ++i)
        m_.velocity[row.body[i]] += h_ * m_.inverse_mass[row.body[i]] * (force * row.j[i]);
      row.j = {};
    }
    row.soft = spring.damping > 0 ? 1 / (h_ * spring.damping) : 0;
    step_.push_back(spring.damping > 0 ? force / spring.damping : 0);
    rows.push_back(row);
  }
  if (!of_.velocities.fits(rows.size())) of_.velocities.analyse(rows, m_.inverse_mass);
  of_.velocities.compute(rows, m_.inverse_mass);
  impulse_.assign(rows.size(), 0);
  std::vector<Real>& wanted = work_.wanted;
  wanted = step_;
  for (int n = 0; n < 2; ++n) {
    for (std::size_t r = 0; r < rows.size(); ++r) {
      Real rate = 0;
      for (int i = 0; i < rows[r].count; ++i)
        rate += glm::dot(rows[r].j[i], m_.velocity[rows[r].body[i]]);
      const bool gives = r >= hard;
      step_[r] = wanted[r] - rate - (gives ? rows[r].soft * impulse_[r] : 0);
    }
    of_.velocities.solve(step_);
    for (std::size_t r = 0; r < rows.size(); ++r) {
      impulse_[r] += step_[r];
      for (int i = 0; i < rows[r].count; ++i) {
        const std::uint32_t b = rows[r].body[i];
        m_.velocity[b] += m_.inverse_mass[b] * (step_[r] * rows[r].j[i]);
      }
    }
  }
}

/// The impulses of curves in a part of the step.
void Rattle::add_impulses() {
  std::size_t row = now_.first_curve;
  for (std::size_t i = 0; i < of_.curves.size(); ++i) {
    const FlatCurve& c = all_.curves[of_.curves[i]];
    for (std::size_t k = 0; k < c.most_places(); ++k, row += c.rows_per_place()) {
      if (!is_active(i, k)) continue;
      means_[i][k].x += lambda_[row] / h_ + impulse_[row];
      if (c.rolls) means_[i][k].y += lambda_[row + 1] / h_ + impulse_[row + 1];
    }
  }
}

/// Results, and the forces of curves.
void Rattle::keep() {
  of_.position.clear(), of_.velocity.clear();
  for (const std::uint32_t b : of_.bodies) {
    const Real drag = world_.bodies.values()[all_.bodies[b].slot].drag;
    of_.position.push_back(m_.position[b]);
    of_.velocity.push_back(std::exp(-drag * whole_) * m_.velocity[b]);
  }
  for (std::size_t i = 0; i < of_.curves.size(); ++i)
    for (std::size_t k = 0; k < kMostPlaces; ++k)
      places_[i][k].force = means_[i][k].x / whole_, places_[i][k].along = means_[i][k].y / whole_;
  std::size_t at = 0;
  of_.ends.assign(kMostPlaces * of_.curves.size(), {});
  for (std::size_t i = 0; i < of_.curves.size(); ++i)
    for (std::size_t k = 0; k < all_.curves[of_.curves[i]].most_places(); ++k)
      of_.ends[kMostPlaces * i + k] = now_.nows[at++];
  of_.places = places_, of_.searched = searched_, of_.moved = true;
}

/// Where curves touch as the step begins: the plane's step is taken under their forces there.
void Rattle::note_starts() {
  std::size_t at = 0;
  of_.starts.assign(kMostPlaces * of_.curves.size(), {});
  for (std::size_t i = 0; i < of_.curves.size(); ++i)
    for (std::size_t k = 0; k < all_.curves[of_.curves[i]].most_places(); ++k)
      of_.starts[kMostPlaces * i + k] = start_.nows[at++];
}

/// A part of the step, to a time in it.
bool Rattle::advance(Real to) {
  collect(start_);
  for (std::size_t i = 0, at = 0; i < of_.curves.size(); ++i) {
    const FlatCurve& c = all_.curves[of_.curves[i]];
    for (std::size_t k = 0; k < c.most_places(); ++k, ++at) {
      if (!is_active(i, k) || start_.nows[at].status == nurbs::ContactStatus::found) continue;
      if (!c.lifts) return false;
      places_[i][k] = {};
    }
  }
  if (!of_.positions.fits(start_.rows.size())) of_.positions.analyse(start_.rows, m_.inverse_mass);
  if (to <= h_ * 1.5) note_starts();
  springs_.clear(), find_springs();
  note_positions(from_);
  kick(0.5);
  for (const std::uint32_t b : of_.bodies) {
    const Vec3 moved = h_ * m_.velocity[b];
    m_.position[b] += moved, m_.gained[b] += moved.z;
  }
  // Those that others move are where they are by then.
  for (const std::uint32_t b : of_.driven) {
    const PlaneBody& body = s_.plane.bodies[b];
    const Vec3 left = (whole_ - to) * m_.velocity[b];
    m_.position[b] = Vec3(body.position.x, body.position.y, body.angle) - left;
    m_.gained[b] = -left.z;
  }
  note_positions(free_);
  if (!close_gaps() || !within_limits()) return false;
  for (std::size_t i = 0; i < of_.bodies.size(); ++i)
    m_.velocity[of_.bodies[i]] += (m_.position[of_.bodies[i]] - free_[i]) / h_;
  kick(0.5), project(), add_impulses();
  return true;
}

void Rattle::note_positions(std::vector<Vec3>& to) const {
  to.clear();
  for (const std::uint32_t b : of_.bodies) to.push_back(m_.position[b]);
}

void Rattle::place_at(const std::vector<Vec3>& positions) {
  for (std::size_t i = 0; i < of_.bodies.size(); ++i) {
    const std::uint32_t b = of_.bodies[i];
    m_.gained[b] += positions[i].z - m_.position[b].z, m_.position[b] = positions[i];
  }
}

/// All that it moves, and all that is moved with it, as the step begins.
void Rattle::begin() {
  for (const auto* list : {&of_.bodies, &of_.driven})
    for (const std::uint32_t b : *list) begin_motion(s_.plane.bodies[b], whole_, b, m_);
}

bool Rattle::go(int parts) {
  begin(), h_ = whole_ / parts;
  places_.clear(), searched_.clear();
  for (const std::uint32_t curve : of_.curves) {
    places_.push_back(all_.curves[curve].places);
    searched_.push_back(all_.curves[curve].searched);
  }
  means_.assign(of_.curves.size(), {});
  for (int i = 0; i < parts; ++i)
    if (!advance((i + 1) * h_)) return false;
  keep();
  return true;
}

int Rattle::fewest_parts() const {
  Real fastest = 0;
  for (const std::uint32_t b : of_.bodies)
    fastest = std::max(fastest, std::abs(m_.velocity[b].z) * whole_);
  return fastest < kMostTurn * kMostParts ? 1 + static_cast<int>(fastest / kMostTurn) : kMostParts;
}

bool Rattle::run() {
  each_joint([&](const PlaneJoint& j) {
    size_ = std::max({size_, glm::length(j.arm_a), glm::length(j.arm_b)});
  });
  bool good = false;
  for (int parts = fewest_parts(); parts <= kMostParts && !good; parts *= 4) good = go(parts);
  begin();
  return good;
}

}  // namespace

void begin_motion(const PlaneBody& b, Real h, std::uint32_t number, Motions& m) {
  m.position[number] = {b.position.x, b.position.y, b.angle};
  m.velocity[number] = m.inverse_mass[number] = Vec3(0), m.gained[number] = 0;
  if (b.kind == PlaneBody::fixed) return;
  m.velocity[number] = {b.velocity.x, b.velocity.y, b.spin};
  if (b.kind == PlaneBody::kinematic)
    m.position[number] -= h * m.velocity[number], m.gained[number] = -h * b.spin;
  else
    m.inverse_mass[number] = {1 / b.mass, 1 / b.mass, 1 / b.inertia};
}

bool move_by_rattle(const World& world, Planar& all, Mechanism& of, Real h) {
  return Rattle(world, all, of, h).run();
}

}  // namespace pantin::detail::planar
