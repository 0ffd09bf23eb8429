// Tracked pairs of surface joints: which are tracked, when all pairs are searched, what ends them.
//
// A surface joint that may lift off tracks several local minima of the gap. Each has a row of its
// own, active or not, so that a minimum that comes nearer is met in time. A minimum that a search
// finds is new only if none of those that are tracked is the same.
#include <algorithm>
#include <limits>

#include "engine/solvers/lagrangian/integrator.hpp"
#include "engine/solvers/lagrangian/surface_spots.hpp"

namespace pantin::detail::lagrangian {
namespace {

using nurbs::ContactStatus;
using Pair = nurbs::CommonNormal;

/// Searches per step for a pair to replace a lost one.
constexpr int kMostLooks = 4;
/// Changes of pair per step: a box rocks from one end of a side to the other before it settles.
constexpr int kMostTurns = 24;
/// m: another pair replaces an active one only if it is deeper by more than this.
constexpr Real kDeeper = 1e-9;
/// Largest travel of a contact point in a substep: a fraction of its surface's size, and a multiple
/// of what rolling brings.
constexpr Real kLeap = 0.1, kRolled = 2;
/// rad: largest error of a normal that is extrapolated by its rate and the rotation of the bodies.
constexpr Real kBend = 0.2;
/// Steps ahead within which approaching pairs are looked for.
constexpr Real kAhead = 2;

Pose a_in_b(const World& world, const SurfaceContact& c) {
  const auto pose = [&](Entity e) { return world.bodies[e].pose; };
  const Pose a = compose(pose(c.a), c.on_a.pose), b = compose(pose(c.b), c.on_b.pose);
  return compose(inverse(b), a);
}

/// Slots that converged to the same pair are merged.
void merge(const Spots& s) {
  const SurfaceContact& c = s.contact();
  for (std::size_t i = 0; i < s.count; ++i)
    for (std::size_t k = i + 1; k < s.count; ++k) {
      if (!s.memory(i).known || !s.memory(k).known ||
          !are_alike(c, s.memory(i).touch.at, s.memory(k).touch.at))
        continue;
      const std::size_t gone = s.bears(k) && !s.bears(i) ? i : k;
      s.memory(gone).known = false, s.m.memory[s.block(gone)].active = false;
    }
}

/// The gap of a tracked pair at the current poses; infinite if the pair is lost.
Real gap_now(const Spots& s, std::size_t n, const Pose& at) {
  const SurfaceContact& c = s.contact();
  const Pair now = track_pair(c, at, s.memory(n).touch.at);
  return now.status == ContactStatus::found ? now.gap : std::numeric_limits<Real>::infinity();
}

/// The slot for a new pair: a free one, else that of the farthest inactive pair beyond it. With one
/// slot, an active pair is replaced if the new one is deeper. None: count.
std::size_t place_for(const Spots& s, const Pair& pair, const Pose& at) {
  for (std::size_t n = 0; n < s.count; ++n)
    if (s.is_open(n)) return n;
  std::size_t worst = s.count;
  Real farthest = pair.gap;
  for (std::size_t n = 0; n < s.count; ++n) {
    if (s.memory(n).is_over() || (s.bears(n) && s.count > 1)) continue;
    const Real gap = gap_now(s, n, at) - (s.bears(n) ? kDeeper : 0);
    if (gap > farthest) farthest = gap, worst = n;
  }
  return worst;
}

/// Upper bound of the speed at which any point of a may approach b's surface, m/s.
Real approach_of(const Spots& s) {
  const SurfaceContact& c = s.contact();
  const Body &a = s.world.bodies[c.a], &b = s.world.bodies[c.b];
  const Pose surface = compose(a.pose, c.on_a.pose);
  const Vec3 at = surface.position, spin = a.angular_velocity - b.angular_velocity;
  const Vec3 v = a.velocity + glm::cross(a.angular_velocity, at - a.pose.position) - b.velocity -
                 glm::cross(b.angular_velocity, at - b.pose.position);
  return glm::length(v) + glm::length(spin) * extent_of(c.on_a);
}

/// Searches all pairs of a contact; those not tracked yet take slots, the nearest first.
void search(const Spots& s, const Pose& at, Real h) {
  const SurfaceContact& c = s.contact();
  bool any_known = false;
  Real most = kDeepest * smaller_size(c);
  if (s.memory(0).was_searched) most = std::max(most, moved(s.memory(0).searched, at).most(c));
  for (std::size_t n = 0; n < s.count; ++n) {
    s.memory(n).searched = at, s.memory(n).is_far = s.memory(n).was_searched = true;
    any_known = any_known || s.memory(n).known;
  }
  Pair found[kMostPairs];
  const Real reach = std::max(smaller_size(c), kAhead * h * approach_of(s));
  const std::size_t count = find_pairs(c, at, {reach, found});
  Real& clear = s.m.scratch.touching[s.first].clear;
  clear = reach;
  for (std::size_t i = 0; i < count; ++i) clear = std::min(clear, found[i].gap);
  std::sort(found, found + count,
            [](const Pair& x, const Pair& y) { return std::abs(x.gap) < std::abs(y.gap); });
  for (std::size_t i = 0; i < count; ++i) {
    bool is_known = false;
    for (std::size_t n = 0; n < s.count; ++n)
      is_known = is_known || (s.memory(n).known && are_alike(c, s.memory(n).touch.at, found[i].at));
    if (is_known || ((any_known || i > 0) && !may_have_met(found[i], most))) continue;
    const std::size_t n = place_for(s, found[i], at);
    if (n == s.count) continue;
    SurfaceMemory& memory = s.memory(n);
    memory.known = memory.is_least = true;
    memory.touch = {found[i].at, {}, s.world.time, 0}, memory.slip = Vec3(0);
    s.m.memory[s.block(n)].active = false;
  }
  for (std::size_t n = 0; n < s.count; ++n) s.memory(n).is_far = !s.memory(n).known;
}

/// Drops minima that left their surfaces; the first one starts at the joint's initial guess.
void begin(const Spots& s) {
  const SurfaceContact& c = s.contact();
  for (std::size_t n = 0; n < s.count; ++n) {
    SurfaceMemory& memory = s.memory(n);
    if (memory.known && !(is_on(c.on_a, memory.touch.at.a) && is_on(c.on_b, memory.touch.at.b)))
      memory.known = false;
  }
  SurfaceMemory& one = s.memory(0);
  if (!one.known && !one.is_far && c.known)
    one.known = true, one.touch = {c.at, {}, s.world.time, 0};
}

/// Whether all pairs are to be searched.
bool wants_search(const Spots& s, const Pose& at) {
  const SurfaceContact& c = s.contact();
  bool any_open = false, is_unsure = false;
  for (std::size_t n = 0; n < s.count; ++n) {
    const SurfaceMemory& memory = s.memory(n);
    any_open = any_open || !memory.is_over();
    is_unsure = is_unsure || (memory.known && !memory.is_least);
    if (s.is_open(n) && !memory.is_far) return true;
  }
  if (!any_open || (!c.lifts && !s.is_open(0))) return false;
  // Two surfaces without hollows have one pair.
  if (c.lifts && s.count == 1 && s.memory(0).known && s.memory(0).is_least && is_convex(c))
    return false;
  const Moved since = moved(s.memory(0).searched, at);
  const bool is_due = is_far(since, c);
  if (!c.lifts) return is_due;
  // With a single slot that is active, only a search reveals another pair that comes near.
  const bool is_urgent = s.count == 1 && since.most(c) > kSearchWay * smaller_size(c);
  return is_unsure || is_due || is_urgent;
}

/// Drops tracked pairs of unilateral joints at which the gap is no longer a minimum. Returns
/// whether an active one was among them.
bool forget_saddles(const Spots& s) {
  bool any_bore = false;
  for (std::size_t n = 0; n < s.count; ++n)
    if (s.memory(n).known && !s.memory(n).is_least) {
      any_bore = any_bore || s.bears(n);
      s.memory(n).known = false, s.m.memory[s.block(n)].active = false;
    }
  return any_bore;
}
bool any_known(const Spots& s) {
  for (std::size_t n = 0; n < s.count; ++n)
    if (s.memory(n).known) return true;
  return false;
}

}  // namespace

void find_touches(const World& world, Island& m, Real h) {
  for (SurfaceFound& found : m.scratch.touching) found.ends = 0;
  for_each_contact(world, m, [&](const Spots& s) {
    const SurfaceContact& c = s.contact();
    begin(s);
    const Pose at = a_in_b(world, c);
    bool fits = false;
    if (c.lifts) {
      if (s.count > 1) merge(s);
      const bool looks = wants_search(s, at), bore = forget_saddles(s);
      if (looks) search(s, at, h);
      // The active pair has no minimum left: the surfaces touch along a line.
      fits = bore && !any_known(s);
    } else if (wants_search(s, at)) {
      search(s, at, h);
    }
    for (std::size_t n = 0; n < s.count; ++n) {
      m.scratch.state.touches[s.first + n] = s.memory(n).touch;
      m.scratch.touching[s.first + n].is_fresh = false;
    }
    if (fits || (!c.lifts && s.is_open(0)))
      m.scratch.lost_touch = static_cast<std::uint32_t>(s.first),
      m.scratch.lost_how = fits ? ContactStatus::degenerate : ContactStatus::lost;
  });
}

namespace {

/// A point of a surface in its frame, and its outward normal; 0 for a curve in space.
struct PlaceOn {
  Vec3 at{0}, normal{0};
};
PlaceOn place_on(const ContactSurface& s, const nurbs::Place& at) {
  if (s.curve) {
    const auto d = nurbs::evaluate(s.curve->curve(), at.u, 1);
    return {d[0], glm::normalize(Vec3(d[1].y, -d[1].x, 0))};
  }
  const nurbs::Jet jet = s.skin->face(at.face).at(at.u, at.v);
  return {jet.s, glm::normalize(glm::cross(jet.u, jet.v))};
}
/// The same on a, with the normal opposed to that of b.
PlaceOn place_on_a(const SurfaceContact& c, const nurbs::Place& at) {
  PlaceOn place = place_on(c.on_a, at);
  place.normal = c.on_a.curve && c.on_b.skin ? Vec3(0) : -place.normal;
  return place;
}

}  // namespace

void note_touches(const World& world, Island& m) {
  for (std::size_t n = 0; n < m.touches.size(); ++n) {
    if (!m.touches[n].known || !is_active(m, m.touch_blocks[n])) continue;
    const SurfaceContact& c = world.surface_contacts.values()[m.touch_sources[n]];
    const nurbs::PlacePair& at = m.scratch.state.touches[n].at;
    SurfaceFound& found = m.scratch.touching[n];
    const PlaceOn on_a = place_on_a(c, at.a), on_b = place_on(c.on_b, at.b);
    found.from[0] = on_a.at, found.from[1] = on_b.at;
    found.normal_from[0] = on_a.normal, found.normal_from[1] = on_b.normal;
    found.knows_rate = false;
  }
}

bool touches_leap(const World& world, Island& m, Real h) {
  for (std::size_t n = 0; n < m.touches.size(); ++n) {
    if (!m.touches[n].known || !is_active(m, m.touch_blocks[n])) continue;
    const SurfaceContact& c = world.surface_contacts.values()[m.touch_sources[n]];
    const nurbs::PlacePair& at = m.scratch.state.touches[n].at;
    const SurfaceFound& found = m.scratch.touching[n];
    const Block& b = m.blocks[m.touch_blocks[n]];
    const auto spin = [&](std::size_t k) {
      return m.scratch.body_states[b.body[k]].angular_velocity;
    };
    const Real turned = h * glm::length(spin(0) - spin(1));
    const Real most = std::max(kLeap, kRolled * turned);
    const PlaceOn now[2] = {place_on_a(c, at.a), place_on(c.on_b, at.b)};
    if (glm::distance(now[0].at, found.from[0]) > most * size_of(c.on_a) ||
        glm::distance(now[1].at, found.from[1]) > most * size_of(c.on_b))
      return true;
    find_turning(world, m, m.touch_blocks[n]);
    for (int k = 0; k < 2; ++k)
      if (now[k].normal != Vec3(0) &&
          glm::distance(now[k].normal, found.normal_from[k] + h * found.normal_rate[k]) >
              kBend + 0.5 * turned * turned)
        return true;
  }
  return false;
}

bool may_turn_over(const World& world, Island& m) {
  StepScratch& scratch = m.scratch;
  if (scratch.lost_touch == UINT32_MAX || scratch.turned_over >= kMostTurns) return false;
  const SurfaceContact& c = world.surface_contacts.values()[m.touch_sources[scratch.lost_touch]];
  if (!c.lifts || !c.on_b.curve || c.spots < 2) return false;
  ++scratch.turned_over;
  return true;
}

Pose a_in_b_now(const Spots& s) {
  const Block& b = s.m.blocks[s.block(0)];
  const auto surface = [&](std::size_t k, const ContactSurface& of) {
    const BodyState& at = s.m.scratch.body_states[b.body[k]];
    return compose({at.position, glm::normalize(glm::quat_cast(at.rotation_matrix))}, of.pose);
  };
  return compose(inverse(surface(1, s.contact().on_b)), surface(0, s.contact().on_a));
}

void look_for_touches(const World& world, Island& m, Real h) {
  for_each_contact(world, m, [&](const Spots& s) {
    for (std::size_t n = 0; n < s.count; ++n) {
      s.memory(n).touch = m.scratch.state.touches[s.first + n];
      // Pairs that ended free their slots.
      if (s.contact().lifts && !s.bears(n) && has_ended(s, n)) s.memory(n).known = false;
    }
    search(s, a_in_b_now(s), h);
    for (std::size_t n = 0; n < s.count; ++n) {
      m.scratch.state.touches[s.first + n] = s.memory(n).touch;
      m.scratch.touching[s.first + n].is_fresh = false;
    }
  });
}

namespace {

/// Whether a search of all pairs may replace the lost one: of a unilateral joint.
bool may_look_again(const SurfaceContact& c, const StepScratch& scratch) {
  return c.lifts && scratch.lost_how == ContactStatus::lost && scratch.relooked < kMostLooks;
}

}  // namespace

bool may_release(const World& world, const Island& m) {
  const StepScratch& scratch = m.scratch;
  if (scratch.lost_touch == UINT32_MAX) return false;
  const SurfaceContact& c = world.surface_contacts.values()[m.touch_sources[scratch.lost_touch]];
  return c.on_rim == OnRim::release && !may_look_again(c, scratch);
}

void release(const World& world, Island& m, std::uint32_t touch, ContactStatus how) {
  m.touches[touch].how = how;
  ++m.released, m.scratch.lost_touch = UINT32_MAX;
  update_kinematics(m), write_all_rows(world, m, {true, false});
  factor(m), find_rank(m);
  m.fresh = m.fresh || row_of(m.settings.integrator).keeps_accelerations;
}

bool release_lost(const World& world, Island& m) {
  StepScratch& scratch = m.scratch;
  if (scratch.lost_touch == UINT32_MAX) return false;
  const std::uint32_t source = m.touch_sources[scratch.lost_touch];
  const SurfaceContact& c = world.surface_contacts.values()[source];
  SurfaceMemory& memory = m.touches[scratch.lost_touch];
  if (may_look_again(c, scratch)) {
    memory.is_least = false, scratch.lost_touch = UINT32_MAX, ++scratch.relooked;
    return true;
  }
  // Of a step that cannot be taken at all, at its start.
  if (c.on_rim == OnRim::release) {
    memory.how = scratch.lost_how;
    ++m.released, scratch.lost_touch = UINT32_MAX;
    return true;
  }
  m.lost_contact = world.surface_contacts.owners()[source], m.lost_how = scratch.lost_how;
  return false;
}

namespace {

/// N, on b, mean over the step.
Vec3 force_on_b(const Island& m, std::size_t block) {
  const Block& b = m.blocks[block];
  Vec3 pull[2] = {Vec3(0), Vec3(0)};
  add_constraint_force({b, jacobian_of(m, b), 1}, &m.forces[b.first_row], pull);
  const bool has = block + 1 < m.blocks.size() && m.blocks[block + 1].kind == BlockKind::roll;
  if (!has) return pull[0];
  const Block& roll = m.blocks[block + 1];
  add_constraint_force({roll, jacobian_of(m, roll), 1}, &m.forces[roll.first_row], pull);
  if (!roll.lock && is_active(m, block) && !is_active(m, block + 1))
    pull[0] +=
        roll.bound * std::abs(m.forces[b.first_row]) * m.scratch.touching[b.first_place].along;
  return pull[0];
}

SurfaceSpot spot_of(const Spots& s, std::size_t n) {
  const std::uint32_t block = s.block(n);
  const SurfaceFound& found = s.m.scratch.touching[s.first + n];
  if (!s.memory(n).known) return {};
  SurfaceSpot spot{is_active(s.m, block), false, found.on_b, found.normal, Vec3(0), found.gap};
  if (!spot.touches) return spot;
  spot.force = force_on_b(s.m, block);
  const bool rubs = s.m.rubs && block + 1 < s.m.blocks.size() &&
                    s.m.blocks[block + 1].kind == BlockKind::roll && !s.m.blocks[block + 1].lock;
  spot.slips = rubs && !is_active(s.m, block + 1);
  return spot;
}

}  // namespace

namespace {

/// Extrapolates the parameter rates by differences, for methods that do not compute them.
void guess_rates(const Spots& s, std::size_t n) {
  const SurfaceCoordinates& before = s.memory(n).touch;
  SurfaceCoordinates& now = s.m.scratch.state.touches[s.first + n];
  const Real time = now.time - before.time;
  const nurbs::PlacePair &p = before.at, &q = now.at;
  const SurfaceContact& c = s.contact();
  now.rates = {};
  if (!(time > 0) || c.on_a.curve || p.a.face != q.a.face || p.b.face != q.b.face) return;
  const auto leaps = [](const nurbs::Face& face, const nurbs::Place& from, const nurbs::Place& to) {
    return std::abs(to.u - from.u) > 0.25 * face.u().domain().width() ||
           std::abs(to.v - from.v) > 0.25 * face.v().domain().width();
  };
  if (leaps(c.on_a.skin->face(p.a.face), p.a, q.a) || leaps(c.on_b.skin->face(p.b.face), p.b, q.b))
    return;
  now.rates = {(q.a.u - p.a.u) / time, (q.a.v - p.a.v) / time, (q.b.u - p.b.u) / time,
               (q.b.v - p.b.v) / time};
}

}  // namespace

void write_back_touches(World& world, Island& m) {
  for_each_contact(world, m, [&](const Spots& s) {
    SurfaceContact& c = world.surface_contacts.values()[m.touch_sources[s.first]];
    c.over = true;
    for (std::size_t n = 0; n < s.count; ++n) {
      SurfaceMemory& memory = s.memory(n);
      const SurfaceFound& found = m.scratch.touching[s.first + n];
      if (row_of(m.settings.integrator).projection_moves) guess_rates(s, n);
      memory.touch = m.scratch.state.touches[s.first + n];
      c.over = c.over && memory.is_over();
      if (c.lifts && memory.known)
        memory.is_least =
            found.pair.status == ContactStatus::found && found.pair.least_curvature > 0;
      const SurfaceSpot spot = spot_of(s, n);
      if (n > 0) {
        c.more[n - 1] = spot;
        continue;
      }
      c.at = memory.touch.at, c.known = memory.known, c.status = memory.how;
      c.touches = spot.touches, c.slips = spot.slips, c.force = spot.force;
      c.point = found.on_b, c.normal = found.normal, c.gap = found.gap;
    }
  });
}

void write_back_touch_forces(World& world, Island& m) {
  for_each_contact(world, m, [&](const Spots& s) {
    SurfaceContact& c = world.surface_contacts.values()[m.touch_sources[s.first]];
    for (std::size_t n = 0; n < s.count; ++n)
      (n == 0 ? c.force : c.more[n - 1].force) = spot_of(s, n).force;
  });
}

}  // namespace pantin::detail::lagrangian
