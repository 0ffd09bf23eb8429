// Ties of a substep by the energy-momentum method: their start, and their multipliers at the end.
#include <algorithm>

#include "engine/joints/reel.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

constexpr std::uint32_t kNobody = UINT32_MAX;
/// Compliance of rigid ties, as a fraction of their response, where kTieSoftness finds no solution,
/// as in a net whose corners are moved apart. Compliance lets redundant loops share their load, and
/// gives a net stretched flat a finite tension.
constexpr Real kYielding = 0.03;
/// Fraction of the island's size: a smaller gap is due to a tie's compliance, whose energy counts.
constexpr Real kClosedGap = 1e-5;

/// Least multiplier of a taut cable, as a fraction of the island's mass times its size.
constexpr Real kLeast = 1e-30;

/// Largest stiffness of a grounded tie, relative to the inertia of its body over the substep: the
/// inverse of a stiffer block would lose the body's own inertia to rounding.
constexpr Real kGroundedStiffness = 1e4;

/// Resets a tie at the start of a substep; arms and impulse are computed anew.
void forget(ConservingTie& t) {
  t.open = t.was_taut = t.followed = t.strikes = t.grounded = false;
  t.a = t.cable = kNobody;
  t.stiffness = t.damping = t.across = t.length = t.rate = t.softness = t.response = 0;
  t.mu = Vec3(0);
}

/// A tie's fixed point in the world: positions before and after the step, velocity at its end.
struct Place {
  Vec3 before, after, velocity;
};

Place place_of(const World& world, const PackedPin& pin, Real h) {
  const bool jumps = pin.held_body != kNobody && world.bodies.values()[pin.held_body].teleport;
  const Vec3 before = jumps ? pin.target : pin.target_before;
  Vec3 velocity = (pin.target - before) / h;
  if (pin.held_body != kNobody) {
    const Body& b = world.bodies.values()[pin.held_body];
    velocity = b.velocity + glm::cross(b.angular_velocity, b.pose.rotation * pin.held_anchor);
  }
  return {before, pin.target, velocity};
}

/// The same in one substep; `gap` is that at the start of the step, which is closed evenly over it.
struct PlaceInStep {
  Place place;
  const StepPart& part;
  Vec3 gap{0};
};

/// A substep of a cable; `gap`, m, likewise.
struct CablePart {
  const StepPart& part;
  Real gap;
};

/// Decides whether a tie's stiffness is part of its body's block in a substep of h.
void ground(const Island& a, ConservingTie& t, Real h) {
  if (t.a != kNobody || t.kind == TieKind::rigid) return;
  const Real mass = a.constants.at(kMass, t.b);
  const Real along = 0.25 * h * h * t.stiffness + 0.5 * h * t.damping;
  t.grounded = along <= kGroundedStiffness * mass;
  const bool is_elastic = t.stiffness > 0 || t.damping > 0;
  if (t.grounded && is_elastic) t.response = h / mass;
}

/// Completes a tie for a substep.
void begin_tie(const World& world, const Island& a, ConservingTie& t, const PlaceInStep& fixed) {
  const auto& [place, part, gap] = fixed;
  const Real begin = part.begin;
  const auto start = [&](std::uint32_t c, Vec3& anchor, Vec3& arm) {
    const Vec3 at = point_on(world, a.slots[c], anchor);
    anchor -= a.constants.vec(kOwnAnchor, c);
    arm = world.bodies.values()[a.slots[c]].pose.rotation * anchor;
    return at;
  };
  const Vec3 way = place.after - place.before;
  t.way = (part.end - begin) * (way + gap);
  t.velocity = part.end == 1 ? place.velocity : (way + gap) / part.whole;
  t.still = t.way == Vec3(0) && t.velocity == Vec3(0);
  t.before = start(t.b, t.anchor_b, t.start_b) -
             (t.a != kNobody ? start(t.a, t.anchor_a, t.start_a) : place.before + begin * way) +
             (1 - begin) * gap;
  ground(a, t, (part.end - begin) * part.whole);
  t.open = t.kind == TieKind::rigid && glm::length(t.before) > kClosedGap * a.size;
  t.still = t.still && !t.open;
}

/// Sets the length of a cable at the end of a substep, and its rate. A cable that starts too long
/// by `gap`, m, becomes as long as it may be evenly over the step.
void reel(const PackedCable& packed, const CableParameters& cable, const CablePart& in,
          ConservingTie& t) {
  const auto& [part, gap] = in;
  const ReeledLength at = reeled_in_step(packed.before(), cable, part.end, part.whole);
  t.length = part.end == 1 ? cable.length : at.length;
  t.rate = at.rate;
  if (gap == 0) return;
  t.still = false;
  if (part.end < 1) t.length += (1 - part.end) * gap, t.rate -= gap / part.whole;
}

/// m: by how much an inextensible cable is longer than it may be at the start of a step.
Real excess_of(const World& world, const PackedCable& cable, Real h) {
  const CableParameters& s = world.cables.values()[cable.cable].joint;
  if (s.compliance > 0) return 0;
  const auto end = [&](std::uint32_t column, std::uint32_t slot, Vec3 anchor) {
    if (column != kNobody) return point_on(world, slot, anchor);
    return point_before(world, slot, anchor, h);
  };
  const Vec3 apart =
      end(cable.column_b, cable.slot_b, s.anchor_b) - end(cable.column_a, cable.slot_a, s.anchor_a);
  return glm::length(apart) - reeled_in_step(cable.before(), s, 0, h).length;
}

/// Whether springs, motors or the like may move the island: the energy that it may have is unknown.
bool has_other_sources(const World& world, const Island& a) {
  const auto turns_itself = [](const PackedJoint& j) {
    return is_actuated(j) || j.drive != UINT32_MAX || j.joint.limits->soft_zone > 0;
  };
  return std::any_of(a.joints.begin(), a.joints.end(), turns_itself) ||
         std::any_of(a.pins.begin(), a.pins.end(),
                     [](const PackedPin& pin) { return pin.compliance > 0; }) ||
         std::any_of(a.cables.begin(), a.cables.end(), [&](const PackedCable& c) {
           const CableParameters& s = world.cables.values()[c.cable].joint;
           return s.compliance > 0 || is_reeled(c.before(), s);
         });
}

/// Warm start: a cable that was taut at the end of the last step starts as taut.
void begin_inextensible(const StepScratch& r, ConservingTie& t, const PackedCable& cable,
                        Real to_mu) {
  PANTIN_ASSERT(t.cable < r.cable_rows.size());
  const Real span = glm::length(t.before);
  t.followed = r.cable_rows[t.cable] == CableRow::followed;
  t.was_taut = cable.lambda > 0 && span > 0 && !t.followed;
  if (t.was_taut) t.kind = TieKind::taut, t.mu = to_mu * cable.lambda / span * t.before;
}

}  // namespace

bool begin_closing(const World& world, Island& a, Real h) {
  bool any = false;
  for (std::size_t i = 0; i < a.pins.size(); ++i) {
    const PackedPin& pin = a.pins[i];
    const Vec3 to = pin.partner == kNobody ? place_of(world, pin, h).before
                                           : point_on(world, a.slots[pin.partner], pin.held_anchor);
    const Vec3 gap = to - point_on(world, a.slots[pin.column], pin.anchor);
    const bool open = pin.compliance == 0 && glm::length(gap) > kClosedGap * a.size;
    a.scratch.pin_gaps[i] = open ? gap : Vec3(0);
    any = any || open;
  }
  bool takes_up = false;
  for (std::size_t i = 0; i < a.cables.size(); ++i) {
    const Real excess = excess_of(world, a.cables[i], h);
    a.scratch.cable_gaps[i] = excess > kClosedGap * a.size ? excess : 0;
    takes_up = takes_up || a.scratch.cable_gaps[i] > 0;
  }
  any = any || (takes_up && !has_other_sources(world, a));
  if (any) begin_watch(world, a);
  return any;
}

void begin_ties(const World& world, Island& a, const StepPart& part) {
  StepScratch& r = a.scratch;
  PANTIN_ASSERT(part.begin < part.end && part.end <= 1);
  PANTIN_ASSERT(r.ties.capacity() >= tie_count(a));
  r.ties.resize(tie_count(a)), r.tie_sets.resize(r.ties.size());
  ConservingTie* next = r.ties.data();
  r.tie_yield = part.yields ? kYielding : kTieSoftness;
  const Real to_mu = 0.5 / (part.whole * part.whole) * (part.end - part.begin) * part.whole;
  for (const PackedPin& pin : a.pins) {
    ConservingTie& t = *next++;
    forget(t);
    t.b = pin.column, t.anchor_b = pin.anchor;
    t.a = pin.partner, t.anchor_a = pin.held_anchor;
    t.kind = pin.compliance > 0 ? TieKind::spring : TieKind::rigid;
    if (pin.compliance > 0) t.stiffness = 1 / pin.compliance, t.damping = pin.damping;
    begin_tie(world, a, t,
              {pin.partner == kNobody ? place_of(world, pin, part.whole) : Place{}, part,
               r.pin_gaps[static_cast<std::size_t>(&pin - a.pins.data())]});
    if (t.kind == TieKind::rigid) t.mu = -to_mu * pin.lambda;
  }
  std::uint32_t led = kNobody;  // cached: several cables may hang from one body
  Pose led_before;
  for (const PackedCable& cable : a.cables) {
    const CableParameters& s = world.cables.values()[cable.cable].joint;
    const bool stretches = s.compliance > 0;
    ConservingTie& t = *next++;
    forget(t);
    const bool has_b = cable.column_b != kNobody;
    PANTIN_ASSERT(has_b || cable.column_a != kNobody);
    t.cable = static_cast<std::uint32_t>(&cable - a.cables.data());
    t.kind = stretches ? TieKind::cable : TieKind::slack;
    if (stretches) t.stiffness = stiffness_of(s);
    t.b = has_b ? cable.column_b : cable.column_a;
    t.anchor_b = has_b ? s.anchor_b : s.anchor_a;
    t.a = has_b ? cable.column_a : kNobody, t.anchor_a = s.anchor_a;
    Place place{};
    if (t.a == kNobody) {
      const std::uint32_t slot = has_b ? cable.slot_a : cable.slot_b;
      const Vec3 anchor = has_b ? s.anchor_a : s.anchor_b;
      if (slot != led) led = slot, led_before = pose_before(world, slot, part.whole);
      place.before = to_world(led_before, anchor);
      place.after = point_on(world, slot, anchor);
      const Body& b = world.bodies.values()[slot];
      place.velocity = b.velocity + glm::cross(b.angular_velocity, b.pose.rotation * anchor);
    }
    begin_tie(world, a, t, {place, part});
    reel(cable, s, {part, r.cable_gaps[t.cable]}, t);
    if (!stretches) begin_inextensible(r, t, cable, to_mu);
  }
}

void store_ties(Island& a, const StepPart& part) {
  const Real to_lambda = 2 * part.whole / (part.end - part.begin);
  PANTIN_ASSERT(a.scratch.ties.size() == tie_count(a));
  auto tie = a.scratch.ties.cbegin();
  for (PackedPin& pin : a.pins) pin.lambda = -to_lambda * (tie++)->mu, pin.reachable = true;
  for (PackedCable& cable : a.cables) cable.lambda = 0;
  for (; tie != a.scratch.ties.cend(); ++tie)
    if (tie->kind != TieKind::slack)
      a.cables[tie->cable].lambda =
          std::max(kLeast * a.mass * a.size, to_lambda * glm::length(tie->mu));
}

}  // namespace pantin::detail::articulated
