// The step of a mechanism by RATTLE: see rattle.hpp.
#include "engine/solvers/planar/rattle.hpp"

#include <algorithm>
#include <cmath>

namespace pantin::detail::planar {
namespace {

constexpr int kMostIterations = 40, kMostParts = 64;
constexpr std::size_t kMostRows = 16000;  // in all substeps; Box2D steps larger mechanisms
constexpr int kHopeful = 5;               // iterations after which gaps must have shrunk by
constexpr Real kHope = 0.1;               // this factor, or they will not converge
constexpr Real kMostPhase = 1.5;          // rad, of the fastest oscillation in a substep
constexpr Real kMostTurn = 0.5;           // rad, of a body in a substep
constexpr Real kMostClosed = 1;           // rad, by which closing turns a body
constexpr Real kStartGap = 1e-8;          // of the size of the joints: steps leave smaller gaps
// Like kGives, with rolling curves. On fixed axes the gap follows from rolling, and from the axes
// alone where the common normal intersects both.
constexpr Real kGivesRolling = 1e-5;
constexpr Real kWidest = 1e3;  // of their size: larger gaps are never closed
constexpr Real kFalls = 0.02;  // the matrix is recomputed unless the residual falls by this factor

Real worst_of(std::span<const Row> rows) {
  Real worst = 0;
  for (const Row& row : rows) {
    if (!std::isfinite(row.c)) return row.c;
    worst = std::max(worst, std::abs(row.c));
  }
  return worst;
}

void append_residuals(std::span<const Row> rows, std::vector<Real>& to) {
  to.clear();
  for (const Row& row : rows) to.push_back(-row.c);
}

}  // namespace

Rattle::Rattle(const World& world, Planar& all, Mechanism& of, Real h)
    : world_(world), all_(all), s_(all.scratch), m_(all.scratch.motions), of_(of), h_(h) {
  each_joint([&](const PlaneJoint& j) {
    size_ = std::max({size_, glm::length(j.arm_a), glm::length(j.arm_b)});
  });
  bool rolls = false;
  for (const std::uint32_t curve : of_.curves) rolls = rolls || all_.curves[curve].rolls;
  gives_ = rolls ? kGivesRolling : kGives;
}

void Rattle::collect(RattleRows& to) {
  to.rows.clear(), to.nows.clear();
  each_joint([&](const PlaneJoint& j) { append_joint_rows(j, m_, to.rows); });
  for (const std::uint32_t gear : of_.gears)
    to.rows.push_back(gear_row(world_, all_, all_.gears[gear]));
  to.first_drive = to.rows.size();
  for (const std::uint32_t drive : of_.drives)
    to.rows.push_back(drive_row(world_, all_, all_.drives[drive]));
  to.first_span = to.rows.size();
  for (const std::uint32_t span : of_.spans)
    to.rows.push_back(span_row(world_, all_, all_.spans[span]));
  to.first_limit = to.rows.size();
  append_limit_rows(to.rows);
  to.first_curve = to.rows.size();
  for (std::size_t i = 0; i < of_.curves.size(); ++i) {
    const FlatCurve& c = all_.curves[of_.curves[i]];
    for (std::size_t k = 0; k < c.most_places(); ++k) {
      PANTIN_ASSERT(i < places_.size() && k < kMostPlaces);
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

void Rattle::shift(std::span<const Row> rows, std::span<const Real> by) {
  PANTIN_ASSERT(by.size() >= rows.size());
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

/// Closes positions along the rows of the start, by Newton's method.
bool Rattle::close_gaps() {
  lambda_.assign(start_.rows.size(), 0);
  soften(start_.rows, gives_);
  Real before = 1e300, first = 1e300;
  int looks = 0, since = 0;
  bool is_due = true, is_anew = false;
  for (int n = 0; n < kMostIterations; ++n) {
    collect(now_);
    if (n == kMostIterations / 2) looks = -kMostIterations;  // no more are added
    const std::optional<bool> changed = switch_places(looks);
    if (!changed) return false;
    if (switch_limits(looks) || *changed) {
      restart(), before = first = 1e300, is_due = true, since = 0;
      continue;
    }
    const Real worst = worst_of(now_.rows);
    const bool stays = is_anew && !(worst < 0.9 * before) && worst <= kAccepted * size_;
    of_.residual = worst;
    if (worst <= kClosed * size_ || stays) {
      if (looks < 0 || !meets_anew()) return true;
      ++looks, restart(), before = first = 1e300, is_due = true, since = 0;
      continue;
    }
    if (since == 0) first = worst;
    if (!(worst < kWidest * size_) || (++since > kHopeful && worst > kHope * first)) return false;
    is_anew = is_due || !(worst < kFalls * before);
    if (is_anew) of_.positions.compute(now_.rows, start_.rows, m_.inverse_mass);
    before = worst, is_due = false;
    append_residuals(now_.rows, step_);
    of_.positions.solve(step_);
    for (std::size_t r = 0; r < step_.size(); ++r) lambda_[r] += step_[r];
    shift(start_.rows, step_);
  }
  return false;
}

/// Closes gaps at the start of the step: a body was teleported, a pin moved, or Box2D crossed a
/// limit. This adds no velocity. False if it does not converge.
bool Rattle::settle() {
  work_.closed.assign(of_.bodies.size(), Vec3(0));
  begin(), take_places(), find_limits(), collect(start_);
  if (!(worst_of(std::span(start_.rows).first(start_.first_curve)) > kStartGap * size_))
    return true;
  note_positions(from_);
  for (int n = 0; n < kMostIterations; ++n) {
    const Real worst = worst_of(start_.rows);
    if (!std::isfinite(worst)) return false;
    if (worst <= kClosed * size_) {
      for (std::size_t i = 0; i < from_.size(); ++i)
        work_.closed[i] = m_.position[of_.bodies[i]] - from_[i];
      return true;
    }
    append_residuals(start_.rows, step_);
    if (!of_.positions.fits(start_.rows.size()))
      of_.positions.analyse(start_.rows, m_.inverse_mass);
    soften(start_.rows, gives_);
    of_.positions.compute(start_.rows, m_.inverse_mass), of_.positions.solve(step_);
    note_positions(free_), shift(start_.rows, step_);
    Real most = 0;
    for (std::size_t i = 0; i < free_.size(); ++i)
      most = std::max(most, std::abs(m_.position[of_.bodies[i]].z - free_[i].z));
    for (std::size_t i = 0; i < free_.size() && most > kMostTurn; ++i)
      free_[i] += kMostTurn / most * (m_.position[of_.bodies[i]] - free_[i]);
    if (most > kMostTurn) place_at(free_);
    find_limits(), collect(start_);
  }
  return false;
}

/// Adds the impulses of joints, drives, spans and curves in a substep.
void Rattle::add_impulses() {
  std::size_t row = 0, joint = 0;
  each_joint([&](const PlaneJoint& j) {
    JointLoad& sum = of_.borne[joint++];
    for (int rows = rows_of(j); rows-- > 0; ++row) {
      const Vec3 on_b = (lambda_[row] / h_ + first_[row]) * start_.rows[row].part(j.b) +
                        impulse_[row] * now_.rows[row].part(j.b);
      const bool turns = on_b.x == 0 && on_b.y == 0;
      sum.force += Vec3(on_b.x, on_b.y, 0) / whole_;
      if (turns) sum.torque += on_b.z / whole_;
    }
  });
  row = now_.first_drive;
  for (const std::uint32_t at : of_.drives) {
    FlatDrive& d = all_.drives[at];
    d.impulse += d.lag.yields ? h_ * d.lag.force : impulse_of(row);
    ++row;
  }
  row = now_.first_span;
  for (std::size_t i = 0; i < of_.spans.size(); ++i, ++row)
    of_.span_loads[i].impulse += impulse_of(row) + h_ * grip(all_.spans[of_.spans[i]]);
  row = now_.first_curve;
  for (std::size_t i = 0; i < of_.curves.size(); ++i) {
    const FlatCurve& c = all_.curves[of_.curves[i]];
    for (std::size_t k = 0; k < c.most_places(); ++k, row += c.rows_per_place()) {
      if (!is_active(i, k)) continue;
      means_[i][k].x += impulse_of(row);
      if (c.rolls) means_[i][k].y += impulse_of(row + 1);
    }
  }
}

/// Applies air drag.
void Rattle::drag(Real time) {
  for (const std::uint32_t b : of_.bodies) {
    const Real rate = world_.bodies.values()[all_.bodies[b].slot].drag;
    if (rate > 0) m_.velocity[b] *= std::exp(-rate * time);
  }
}

/// Stores results, and the forces of curves.
void Rattle::keep() {
  of_.position.clear(), of_.velocity.clear();
  for (const std::uint32_t b : of_.bodies)
    of_.position.push_back(m_.position[b]), of_.velocity.push_back(m_.velocity[b]);
  for (std::size_t i = 0; i < of_.curves.size(); ++i)
    for (std::size_t k = 0; k < kMostPlaces; ++k)
      places_[i][k].force = means_[i][k].x / whole_, places_[i][k].along = means_[i][k].y / whole_;
  std::size_t at = 0;
  of_.ends.assign(kMostPlaces * of_.curves.size(), {});
  for (std::size_t i = 0; i < of_.curves.size(); ++i)
    for (std::size_t k = 0; k < all_.curves[of_.curves[i]].most_places(); ++k)
      of_.ends[kMostPlaces * i + k] = now_.nows[at++];
  for (std::size_t i = 0; i < of_.spans.size(); ++i)
    of_.span_loads[i].slips = all_.spans[of_.spans[i]].slips;
  of_.places = places_, of_.searched = searched_, of_.moved = true;
}

/// Places kinematic bodies at a time in the step, from which drives demand what they do then.
void Rattle::drive_others(Real time) {
  m_.time = time;
  for (const std::uint32_t b : of_.driven) {
    const PlaneBody& body = s_.plane.bodies[b];
    const Vec3 left = (whole_ - time) * m_.velocity[b];
    m_.position[b] = Vec3(body.position.x, body.position.y, body.angle) - left;
    m_.gained[b] = -left.z;
  }
}

/// The free motion from the start of a substep.
void Rattle::drift() {
  kick(End::start);
  for (const std::uint32_t b : of_.bodies) {
    const Vec3 moved = h_ * m_.velocity[b];
    m_.position[b] += moved, m_.gained[b] += moved.z;
  }
  drive_others(end_);
  note_positions(free_);
}

/// A substep up to a time in the step.
bool Rattle::advance(Real to) {
  end_ = to;

  find_limits(), collect(start_);
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
  find_springs();
  note_positions(from_), note_velocities(work_.from_velocity);
  drift();
  if (!close_gaps()) return false;
  for (std::size_t i = 0; i < of_.bodies.size(); ++i) {
    const Vec3 closed = m_.position[of_.bodies[i]] - free_[i];
    const Real turned = m_.position[of_.bodies[i]].z - from_[i].z;
    if (std::abs(closed.z) > kMostClosed || std::abs(turned) > most_turn_) return false;
    m_.velocity[of_.bodies[i]] += closed / h_;
  }
  kick(End::end), add_impulses();
  return true;
}

void Rattle::note_positions(std::vector<Vec3>& to) const {
  to.clear();
  for (const std::uint32_t b : of_.bodies) to.push_back(m_.position[b]);
}

void Rattle::note_velocities(std::vector<Vec3>& to) const {
  to.clear();
  for (const std::uint32_t b : of_.bodies) to.push_back(m_.velocity[b]);
}

void Rattle::place_at(const std::vector<Vec3>& positions) {
  for (std::size_t i = 0; i < of_.bodies.size(); ++i) {
    const std::uint32_t b = of_.bodies[i];
    m_.gained[b] += positions[i].z - m_.position[b].z, m_.position[b] = positions[i];
  }
}

/// Sets all bodies, and kinematic ones, to the start of the step.
void Rattle::begin() {
  m_.time = 0;
  for (const auto* list : {&of_.bodies, &of_.driven})
    for (const std::uint32_t b : *list) begin_motion(s_.plane.bodies[b], whole_, b, m_);
  for (std::size_t i = 0; i < of_.bodies.size(); ++i) {
    const std::uint32_t b = of_.bodies[i];
    m_.position[b] += work_.closed[i], m_.gained[b] += work_.closed[i].z;
  }
}

void Rattle::take_places() {
  places_.clear(), searched_.clear();
  for (const std::uint32_t curve : of_.curves) {
    places_.push_back(all_.curves[curve].places);
    searched_.push_back(all_.curves[curve].searched);
  }
}

bool Rattle::go(int parts) {
  begin(), take_places(), h_ = whole_ / parts;
  drag(0.5 * whole_);
  means_.assign(of_.curves.size(), {});
  of_.borne.assign(of_.links.size() + of_.pins.size(), {});
  of_.span_loads.assign(of_.spans.size(), {});
  for (const std::uint32_t drive : of_.drives) all_.drives[drive].impulse = 0;
  for (int i = 0; i < parts; ++i)
    if (!advance((i + 1) * h_)) return false;
  drag(0.5 * whole_);
  keep();
  return true;
}

/// From the rotation rates of bodies, and their oscillation frequencies under joint loads.
Real Rattle::fewest_parts() {
  Real most = 0;
  for (const std::uint32_t b : of_.bodies)
    most = std::max(most, std::abs(m_.velocity[b].z) * whole_ / kMostTurn);
  // A varying number of substeps costs more accuracy than long ones, until these are too long.
  if (most > 1) most *= 2;
  for (const std::uint32_t b : of_.bodies) m_.gained[b] = 0;  // scratch: squared frequency, 1/s^2
  each_joint([&](const PlaneJoint& j) {
    const Real force = glm::length(j.load.force);
    m_.gained[j.a] += force * glm::length(j.arm_a) * m_.inverse_mass[j.a].z;
    m_.gained[j.b] += force * glm::length(j.arm_b) * m_.inverse_mass[j.b].z;
  });
  for (const std::uint32_t b : of_.bodies)
    most = std::max(most, std::sqrt(m_.gained[b]) * whole_ / kMostPhase);
  return 1 + std::floor(most);
}

bool Rattle::take_step() {
  bool good = false;
  of_.moved = false;
  if (settle()) {
    const std::size_t affordable = kMostRows / (1 + start_.rows.size());
    const int most = static_cast<int>(std::clamp<std::size_t>(affordable, 4, kMostParts));
    int parts = static_cast<int>(std::min<Real>(fewest_parts(), most));
    for (; !good; parts = std::min(2 * parts, most)) {
      for (const std::uint32_t span : of_.spans) all_.spans[span].slips = 0;
      most_turn_ = parts < most ? 1.5 * kMostTurn : kWidest;  // bodies may accelerate in the step
      good = go(parts);
      if (good && overloads()) good = go(parts);
      if (parts == most) break;
    }
  }
  for (const std::uint32_t span : of_.spans) all_.spans[span].slips = 0;
  work_.closed.assign(of_.bodies.size(), Vec3(0));
  begin();
  return good;
}

bool Rattle::run() {
  bool good = take_step();
  while (yield_drives(good ? StepOutcome::taken : StepOutcome::failed)) good = take_step();
  return good;
}

bool move_by_rattle(const World& world, Planar& all, Mechanism& of, Real h) {
  return Rattle(world, all, of, h).run();
}

}  // namespace pantin::detail::planar
