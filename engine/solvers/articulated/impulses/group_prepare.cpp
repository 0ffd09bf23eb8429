// A group at the poses of the start of a substep: trees, loops, ties, active contacts.
#include <algorithm>

#include "engine/solvers/articulated/impulses/group_lanes.hpp"
#include "engine/solvers/articulated/impulses/group_threads.hpp"
#include "engine/solvers/articulated/impulses/group_ties.hpp"

namespace pantin::detail::articulated {
namespace {

/// Newton iterations that close loops, of few ties and of many.
constexpr int kClosingRounds = 16, kClosingRoundsOfMany = 4;
/// Rounds in which cables that are too long are shortened.
constexpr int kShorteningRounds = 8;
constexpr std::size_t kManyTies = 24;
/// Multiples of GroupLoops::open: many ties with wider gaps are given as many rounds as few.
constexpr Real kWideOpen = 50;
/// m/s: margin on closing speeds, since impulses of the substep may make bodies approach faster;
/// the largest speed in the group, if that is more.
constexpr Real kSuddenSpeed = 2;

/// Whether two bodies may touch at a contact within the substep.
bool is_near(const Group& g, const GroupContact& c, Real h, Real sudden) {
  const Vec3 n = c.axes[0];
  const Side a(g, c.a), b(g, c.b);
  const Real closing = -glm::dot(n, a.speed_at(c.arm_a) - b.speed_at(c.arm_b));
  return c.impulse.x > 0 || c.gap < h * (sudden + std::max(Real(0), closing));
}

/// Prepares the responses of two bodies in trees. `known`: the last cross response.
void prepare_ends(const Group& g, const GroupContact& c, std::uint32_t& known) {
  prepare_looped(g, c.a), prepare_looped(g, c.b);
  if (c.cross == known || c.cross == kNoNode) return;
  g.crosses[known = c.cross] = cross_response_of(g, c.a, c.b);
}

/// Prepares the contacts of pairs, of which those of the same two bodies follow one another.
/// `sudden`: margin on closing speeds, m/s.
void prepare_pairs(const Group& g, std::span<GroupPair> pairs, const Substep& s, Real sudden) {
  std::uint32_t known = kNoNode;
  for (GroupPair& p : pairs) {
    p.working = 0;
    for (GroupContact& c : g.contacts.subspan(p.first, p.count)) {
      follow(g, c);
      place(g, c);
      if (s.hard) lead(g, c, s.h);
      c.works = is_near(g, c, s.reach, sudden);
      if (!c.works) c.impulse = Vec3(0);
      p.working += c.works;
    }
    if (p.in_lanes && !s.hard) continue;
    const bool any = p.working > 0;
    if (any) prepare_ends(g, g.contacts[p.first], known);
    prepare_pair(g, p);
  }
}

/// Prepares the contacts of all pairs.
void prepare_contacts(const Group& g, const Substep& s, Real sudden) {
  if (!g.loops.empty()) return prepare_pairs(g, g.pairs, s, sudden);  // they share responses
  // Pairs of the same two bodies share a response as well, and stay together.
  const auto begin_of = [&](std::size_t i) {
    const auto follows = [&](std::size_t p) {
      return have_same_bodies(g.contacts[g.pairs[p].first], g.contacts[g.pairs[p - 1].first]);
    };
    while (i > 0 && i < g.pairs.size() && follows(i)) ++i;
    return i;
  };
  in_parts(g.threads, g.pairs.size(), kLeastInPart, [&](const ListPart& of) {
    const std::size_t begin = begin_of(of.begin), end = begin_of(of.end);
    prepare_pairs(g, g.pairs.subspan(begin, end - begin), s, sudden);
  });
}

}  // namespace

void restore_velocities(const Group& g) {
  for (const GroupNode& n : g.nodes) g.bodies[n.body].velocity = n.velocity;
}

void prepare_closed(const Group& g, const GroupPart& part, Real h) {
  stiffen(g, h);
  if (are_open(g)) {
    press(g);
    bool open = true;
    for (int round = 0; open && round < kClosingRounds; ++round) {
      if (round >= kClosingRoundsOfMany && g.ties.size() >= kManyTies && !are_open(g, kWideOpen))
        break;
      prepare_trees(g, part);
      prepare_loops(g);
      open = close_loops(g, part);
      restore_velocities(g);
    }
    release(g);
  }
  prepare_trees(g, part);
  prepare_loops(g);
}

void shorten_all(const Group& g, const GroupPart& part, Real h) {
  for (int round = 0; round < kShorteningRounds && shorten_cables(g, part); ++round) {
    restore_velocities(g);
    centre_bodies(g);
    prepare_closed(g, part, h);
  }
}

void prepare_group(const Group& g, const Substep& s) {
  const GroupPart& part = s.part;
  centre_bodies(g);
  prepare_closed(g, part, part.h);
  shorten_all(g, part, part.h);
  Real sudden = kSuddenSpeed;
  for (const GroupBody& b : g.bodies) sudden = std::max(sudden, glm::length(b.velocity));
  sudden += speed_by_actuators(g, part.h);
  for (GroupTie& t : g.ties)
    if (t.kind != GroupTie::Kind::rigid) prepare_tie(g, t, part.h);
  prepare_contacts(g, s, sudden);
  if (!s.hard) prepare_lanes(g);
}

void prepare_touching(const Group& g) {
  centre_bodies(g);
  for (GroupContact& c : g.contacts) {
    if (!c.works) continue;
    place(g, c);
    c.works = c.impulse.x > 0 || c.gap <= 0;
  }
  for (GroupPair& p : g.pairs) prepare_pair(g, p);
}

}  // namespace pantin::detail::articulated
