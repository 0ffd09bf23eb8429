// Sleep of groups: islands that rest on one another fall asleep together, beside others of their
// group that go on moving.
#include <algorithm>
#include <cmath>

#include "engine/contact/detect.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/impulses/contact_groups.hpp"
#include "engine/solvers/articulated/impulses/group_points.hpp"
#include "engine/solvers/articulated/impulses/meetings.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// Error of Contact::rest at which bodies may fall asleep, as a fraction of the shallow overlap.
constexpr Real kSettled = 5e-4;
/// Sleep freezes forces: it waits until speeds fall below this fraction of the sleep speed, for
/// this time, s, and so many steps, or for the last time, s.
constexpr Real kDead = 1e-3, kTimeToSettle = 0.15, kStepsToSettle = 8, kPatience = 3;
/// In heaps of free bodies it waits for as many times sqrt(size / g), in which a slow fall grows
/// e-fold, at least for kPatienceInHeap, s.
constexpr Real kFolds = 5, kPatienceInHeap = 1;
/// There this fraction of the bodies may creep, as balls without rolling friction do for long: at a
/// speed this many times larger. One that is not faster than kStirs times that loses as many times
/// the time that it has been still as it moves. All may spin this many times faster.
constexpr Real kCreeping = 0.1, kCreeps = 5, kStirs = 4, kForgets = 3, kSpinsInHeap = 10;
/// Trees of a group from which on it is a pile: there limbs of those that lie on one another are
/// slowed before they sleep.
constexpr std::size_t kPile = 4;
/// What keeps a part of a group awake, flags of its first island: motion, of itself or by what
/// drives it. Of any island: it may speed up by itself; it lies on another of several bodies, or
/// bears it.
constexpr std::uint8_t kMoves = 1, kUnsettled = 2, kDeep = 4, kAlive = 8, kPowered = 16,
                       kDriven = 32, kPiled = 64;

/// Whether a body is the first of its island.
bool is_first(const Group& g, const GroupBody& b) {
  return b.node == kNoNode || g.nodes[b.node].column == 0;
}

/// s: time for which a body of a heap of free bodies has to be still.
Real patience_in_heap(const World& world, const Island& a) {
  const Real weight = glm::length(world.gravity);
  const Real waits = weight > 0 ? kFolds * std::sqrt(a.size / weight) : kPatience;
  return std::clamp(waits, kPatienceInHeap, kPatience);
}

/// Whether a moving surface acts on this contact: it carries bodies along, or slips under them.
bool bears_moving_surface(const GroupContact& c) {
  return c.passed.x > 0 && (c.surface_first != 0 || c.surface_second != 0);
}

/// The parts of a group: islands that bear one another, or may soon.
class Parts {
 public:
  Parts(World& world, const Group& g, Real h) : r_(world.memory.of<Islands>().groups) {
    const IslandVector& list = islands_of(world);
    Real fastest = 0;
    for (const GroupBody& b : g.bodies) {
      if (b.per_mass == 0 || !is_first(g, b)) continue;
      const Island& a = list[b.island];
      r_.flags[b.island] = has_power(world, a) ? kPowered : 0, r_.creeping[b.island] = 0;
      const Real fall = a.contact_active ? 0 : fall_of(world, a, h);
      fastest = std::max(fastest, speed_bound(world, a) + fall);
    }
    for (const GroupContact& c : g.contacts) {
      if (g.is_fixed(c)) continue;
      const std::uint32_t a = g.a(c).island, b = g.b(c).island;
      const Real near = kStaysAwake * (touching_gap(list[a], list[b]) + h * fastest);
      const bool powered = ((r_.flags[a] | r_.flags[b]) & kPowered) != 0;
      if (c.passed.x > 0 || c.gap < near || powered) r_.sets.join(a, b);
    }
    for (const GroupContact& c : g.contacts) add(g, c);
  }
  std::uint8_t& of(std::uint32_t island) { return r_.flags[r_.sets.root(island)]; }
  bool is_piled(std::uint32_t island) const { return (r_.flags[island] & kPiled) != 0; }
  /// In a heap: bodies of the part that creep, beyond those that may.
  Real& creeping(std::uint32_t island) { return r_.creeping[r_.sets.root(island)]; }

 private:
  void add(const Group& g, const GroupContact& c) {
    std::uint8_t& part = of(g.a(c).island);
    const GroupBody& b = g.b(c);
    const bool is_carried = g.is_fixed(c) && (b.velocity != Vec3(0) || b.spin != Vec3(0));
    if (is_carried || bears_moving_surface(c)) part |= kMoves | kDriven;
    if (!(c.settling <= kSettled * c.shallow)) part |= kUnsettled;
    if (is_deep(c)) part |= kDeep;
    if (c.passed.x > 0 && has_joints(g, g.a(c)) && has_joints(g, b) && g.a(c).island != b.island)
      r_.flags[g.a(c).island] |= kPiled, r_.flags[b.island] |= kPiled;
  }
  GroupScratch& r_;
};

}  // namespace

void let_sleep(World& world, const Group& g, Real h) {
  IslandVector& list = islands_of(world);
  for (const GroupContact& c : g.contacts) {
    if (!(c.passed.x > 0)) continue;
    list[g.a(c).island].contact_active = true;
    if (!g.is_fixed(c)) list[g.b(c).island].contact_active = true;
  }
  Parts parts(world, g, h);
  const bool is_heap = g.trees.empty() && !g.has_at_most(kFewBodies);
  const bool is_pile = g.trees.size() >= kPile;
  const Real settling = std::max(kTimeToSettle, kStepsToSettle * h);
  bool rested = false;  // current island; among trees, arms may swing for long
  for (const GroupBody& f : g.bodies) {
    if (f.per_mass == 0) continue;
    Island& a = list[f.island];
    std::uint8_t& part = parts.of(f.island);
    const Real slow = a.settings.sleep_speed;
    const Real speed = glm::length(f.velocity), spin = glm::length(f.spin);
    const bool drives = f.node != kNoNode && g.nodes[f.node].is_driven;
    if (drives) part |= kDriven;
    if (is_first(g, f)) {
      a.quiet_time += h;  // unless one of its bodies moves
      const bool sways = is_pile && parts.is_piled(f.island);
      const Limbs limbs = sways ? Limbs::sway : Limbs::sway_a_little;
      rested = !g.trees.empty() && has_rested(world, a, h, limbs) && (part & kDeep) == 0;
    }
    const Real turning = spin / ((is_heap ? kSpinsInHeap : 1) * kTurning);
    const bool is_still = std::max(speed, turning) < slow;
    const Real creep = std::max(speed / kCreeps, turning);
    if (is_heap) parts.creeping(f.island) += (is_still ? 0 : 1) - kCreeping;
    if (!a.contact_active || drives || !(is_heap ? creep < kStirs * slow : is_still))
      a.quiet_time = 0;
    else if (is_heap && !(creep < slow))
      a.quiet_time = std::max(Real(0), a.quiet_time - kForgets * h);
    const bool dead = speed < kDead * slow && spin < kTurning * kDead * slow;
    if (!dead) part |= kAlive;
    const bool settles = dead && (part & kUnsettled) == 0;
    const bool is_parting = g.trees.empty() && (part & kDeep) != 0 && a.quiet_time < kPatience;
    const Real waits = settles ? settling : is_heap ? patience_in_heap(world, a) : kPatience;
    if (drives || is_parting || !(rested || a.quiet_time > waits)) part |= kMoves;
  }
  for (const GroupTie& t : g.ties) {
    const bool is_slack = t.kind != GroupTie::Kind::cable || t.passed.x == 0;
    if (!is_slack && (parts.of(t.island) & kAlive) != 0) parts.of(t.island) |= kMoves;
  }
  for (const GroupTree& t : g.trees)
    if (t.from != t.to || t.held_spin != Vec3(0)) parts.of(t.island) |= kMoves | kDriven;
  for (const GroupBody& f : g.bodies) {
    if (f.per_mass == 0 || !is_first(g, f)) continue;
    Island& a = list[f.island];
    const std::uint8_t part = parts.of(f.island);
    if ((part & kMoves) == 0 && !(is_heap && parts.creeping(f.island) > 0))
      fall_asleep(world, a);
    else if (is_pile && parts.is_piled(f.island) && (part & kDriven) == 0 && !has_power(world, a))
      slow_limbs(world, a, h);
  }
}

}  // namespace pantin::detail::articulated
