// Rolling and spinning friction: for two bodies one contact point of torques, by the law in
// engine/contact/rolling_friction.hpp. Torques are divided by an arm, so they have the units of the
// other points.
#include "engine/contact/contact_axes.hpp"
#include "engine/contact/rolling_friction.hpp"
#include "engine/solvers/lagrangian/contacts.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// Iterations, and the relative change that ends them.
constexpr int kIterations = 60;
constexpr Real kTolerance = 1e-15;

/// The contacts [from, to) of two bodies.
struct Pair {
  std::size_t from, to;
};

/// m: largest distance of the contacts from the mass centres of bodies that move.
Real arm_of(const World& world, const ContactScratch& r, const Pair& pair) {
  Real most = 0;
  for (std::size_t i = pair.from; i < pair.to; ++i) {
    const ContactPoint& p = r.points[i];
    const Contact& c = contacts_of(world)[p.contact];
    if (p.owner[0] != kNoIndex) most = std::max(most, glm::length(c.point_a));
    if (p.owner[1] != kNoIndex) most = std::max(most, glm::length(c.point_b));
  }
  return most > 0 ? most : 1;
}

void add_pair(const World& world, ContactScratch& r, const Pair& pair, Real h) {
  bool resists = false;
  for (std::size_t i = pair.from; i < pair.to; ++i)
    resists = resists || contact::rolling_lengths(contacts_of(world)[r.points[i].contact]).any();
  if (!resists) return;
  ContactPoint p;
  p.rolling = static_cast<std::uint32_t>(r.rollings.size());
  RollingAt all;
  all.first_length = r.lengths.size(), all.arm = arm_of(world, r, pair);
  Vec3 normal(0), torque(0);
  for (std::size_t i = pair.from; i < pair.to; ++i) {
    const Contact& c = contacts_of(world)[r.points[i].contact];
    const contact::RollingLengths lengths = contact::rolling_lengths(c);
    r.lengths.push_back({lengths.spinning / all.arm, lengths.rolling / all.arm});
    r.points[i].rolling = p.rolling;
    normal += r.points[i].axes[0], torque += c.torque_lambda / h;
  }
  const ContactPoint& first = r.points[pair.from];
  contact::set_axes(p.axes, contact::shared_normal(normal, first.axes[0]));
  for (const int s : {0, 1})
    p.owner[s] = first.owner[s], p.column[s] = first.column[s], p.obstacle[s] = first.obstacle[s];
  p.share = first.share, p.lasting = contact::along_axes(p.axes, torque) / all.arm;
  if (!is_finite(p.lasting)) p.lasting = Vec3(0);
  r.rollings.push_back(all), r.points.push_back(p);
}

}  // namespace

void list_rolling(const World& world, ContactScratch& r, Real h) {
  r.rollings.clear(), r.lengths.clear();
  const std::size_t contacts = r.points.size();
  const auto at = [&](std::size_t i) -> const Contact& {
    return contacts_of(world)[r.points[i].contact];
  };
  for (Pair pair{0, 0}; pair.from < contacts; pair.from = pair.to) {
    const Contact& c = at(pair.from);
    while (pair.to < contacts && at(pair.to).slot_a == c.slot_a && at(pair.to).slot_b == c.slot_b)
      ++pair.to;
    add_pair(world, r, pair, h);
  }
}

void find_rolling_points(ContactScratch& r) {
  for (std::uint32_t i = 0; i < r.points.size(); ++i) {
    const ContactPoint& p = r.points[i];
    if (p.contact == kNoIndex || p.rolling == kNoIndex) continue;
    RollingAt& all = r.rollings[p.rolling];
    if (all.count++ == 0) all.first = i;
  }
}

bool is_any_closed(const ContactScratch& r, const RollingAt& all) {
  const auto points = std::span(r.points).subspan(all.first, all.count);
  return std::any_of(points.begin(), points.end(), [](const ContactPoint& p) { return p.closed; });
}

contact::RollingBounds rolling_bounds(const ContactScratch& r, const RollingAt& all) {
  contact::RollingBounds most;
  for (std::uint32_t i = 0; i < all.count; ++i) {
    const ContactPoint& p = r.points[all.first + i];
    if (p.closed && p.works)
      most.add(r.lengths[all.first_length + i], std::max(Real(0), p.lasting.x));
  }
  return most;
}

Vec3 solve_rolling(const ContactScratch& r, const ContactPoint& p, Vec3 torque) {
  const Mat3& w = p.response;
  const contact::RollingBounds most = rolling_bounds(r, r.rollings[p.rolling]);
  const Vec3 free = p.speed - w * torque;
  const Real soft = softest_of(w);
  if (can_spin(w))
    if (const Vec3 stopped = stop(w, free); most.bounded(stopped) == stopped) return stopped;
  for (int n = 0; n < kIterations; ++n) {
    const Vec3 before = torque;
    torque.x = can_spin(w) ? torque.x - (free + w * torque).x / w[0][0] : 0;
    torque = most.bounded(torque);
    const Vec3 speed = free + w * torque;
    if (soft > 0) torque.y -= speed.y / soft, torque.z -= speed.z / soft;
    torque = most.bounded(torque);
    const Vec3 change = torque - before;
    if (glm::dot(change, change) <= kTolerance * kTolerance * glm::dot(torque, torque)) break;
  }
  return torque;
}

Vec3 rolling_speed(const World& world, const ContactScratch& r, const ContactPoint& p) {
  Vec3 turn(0);
  for (int s = 0; s < 2; ++s) {
    const Real sign = s == 0 ? 1 : -1;
    if (p.end[s] == kNoIndex) {
      turn += sign * p.obstacle[s].spin;
      continue;
    }
    const ContactEnd& e = r.ends[p.end[s]];
    turn += sign * islands_of(world)[e.island].scratch.state.w[e.column];
  }
  return r.rollings[p.rolling].arm * contact::along_axes(p.axes, turn);
}

Real free_rolling(const Island& m, std::uint32_t column, const RollingAt& all) {
  const Vec3 i = m.inertia[column];
  return all.arm * all.arm / std::min({i.x, i.y, i.z});
}

}  // namespace pantin::detail::lagrangian
