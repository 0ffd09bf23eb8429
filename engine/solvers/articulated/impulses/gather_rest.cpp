// The rows of the factor for a group that may be at rest (group_rest.cpp).
#include <algorithm>
#include <limits>

#include "engine/solvers/articulated/impulses/gather.hpp"
#include "engine/solvers/articulated/impulses/graph_order.hpp"
#include "engine/solvers/articulated/impulses/group_resting.hpp"

namespace pantin::detail::articulated {
namespace {

/// Block products of the factor, per contact: above this, sweeps are cheaper.
constexpr std::size_t kMostProducts = 50;
/// The same per body of a group that glides, which is solved in every substep: towers have fewer.
constexpr std::size_t kMostGlidingProducts = 8;
/// Sizes of a body by which the heaviest one would press its tree into contact springs.
constexpr Real kSagsUnderOne = 0.004;
/// Bodies of groups with pressed trees: the search takes too long among more.
constexpr std::size_t kMostPressed = 64;

/// The graph of contacts, joints and cables of the last group's free bodies and trees.
void link_bodies(GroupScratch& r, const GroupScratch::Range& range, std::size_t count) {
  const auto contacts = std::span(r.contacts).subspan(range.first_contact);
  find_links(r, count, [&](auto&& visit) {
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      const GroupContact& c = contacts[i];
      if (c.b < count && (i == 0 || !have_same_bodies(c, contacts[i - 1]))) visit(c.a, c.b);
    }
    for (const GroupNode& n : std::span(r.nodes).subspan(range.first_node))
      if (n.parent != kNoNode) visit(n.body, r.nodes[range.first_node + n.parent].body);
    for (const GroupTie& t : std::span(r.ties).subspan(range.first_tie))
      if (t.a < count && t.b < count && t.a != t.b) visit(t.a, t.b);
  });
}

/// Room for the rows of joints, ties and rolling friction.
void add_links(GroupScratch& r, const GroupScratch::Range& range) {
  std::size_t rows = 3 * (r.rollings.size() - range.first_rolling);
  for (const GroupTie& t : std::span(r.ties).subspan(range.first_tie))
    rows += t.kind == GroupTie::Kind::cable ? 1 : 3;
  for (const GroupNode& n : std::span(r.nodes).subspan(range.first_node))
    if (!n.free_root)
      rows += kMostJointLinks + (n.is_limited ? kMostLimitLinks : 0) +
              (n.has_spring ? kMostSpringLinks : 0);
  r.rest_links.resize(r.rest_links.size() + rows);
}

std::size_t pairs_of(std::span<const GroupContact> contacts) {
  std::size_t pairs = 0;
  for (std::size_t i = 0; i < contacts.size(); ++i)
    pairs += i == 0 || !have_same_bodies(contacts[i], contacts[i - 1]);
  return pairs;
}

/// Whether a body or tree presses trees of the last group too hard for sweeps. Cables and loops are
/// left to these, and so is what bounces or is driven.
bool are_trees_pressed(const GroupScratch& r, const GroupScratch::Range& range, std::size_t free,
                       Real h) {
  const auto bodies = std::span(r.bodies).subspan(range.first_body);
  const auto contacts = std::span(r.contacts).subspan(range.first_contact);
  const auto nodes = std::span(r.nodes).subspan(range.first_node);
  const auto trees = std::span(r.trees).subspan(range.first_tree);
  const auto bounces = [](const GroupContact& c) { return c.restitution > 0; };
  const auto is_driven = [](const GroupNode& n) { return n.is_driven; };
  if (free > kMostPressed || std::any_of(contacts.begin(), contacts.end(), bounces) ||
      std::any_of(nodes.begin(), nodes.end(), is_driven))
    return false;
  const auto weight_of = [&](const GroupTree& t) {
    Vec3 weight(0);
    for (const GroupNode& n : nodes.subspan(t.first, t.count))
      weight += n.mass * bodies[n.body].acceleration;
    return glm::length(weight);
  };
  Real heaviest = 0;  // N
  for (const GroupBody& b : bodies.first(free))
    if (b.node == kNoNode) heaviest = std::max(heaviest, glm::length(b.acceleration) / b.per_mass);
  for (const GroupTree& t : trees) heaviest = std::max(heaviest, weight_of(t));
  const Real stiffness = spring_stiffness(h);
  return std::any_of(trees.begin(), trees.end(), [&](const GroupTree& t) {
    Real mass = 0, smallest = std::numeric_limits<Real>::infinity();
    for (const GroupNode& n : nodes.subspan(t.first, t.count))
      mass += n.mass, smallest = std::min(smallest, size_of(bodies[n.body]));
    return heaviest > weight_of(t) && heaviest > kSagsUnderOne * stiffness * mass * smallest;
  });
}

}  // namespace

void gather_resting(GroupScratch& r, GroupScratch::Range& range, Real h) {
  const auto bodies = std::span(r.bodies).subspan(range.first_body);
  const bool is_free = r.nodes.size() == range.first_node;
  for (const GroupContact& c : std::span(r.contacts).subspan(range.first_contact))
    if (c.impulse.x > 0 || (is_free && bears(c))) bodies[c.a].touched = bodies[c.b].touched = true;
  const std::size_t count = free_bodies(bodies);
  const auto contacts = std::span(r.contacts).subspan(range.first_contact);
  if (count < 2) return;
  const bool may_rest = !range.waits && have_faces(contacts.size(), pairs_of(contacts));
  const bool calm = may_rest && is_calm(bodies, count, h);
  const bool pressed =
      r.ties.size() == range.first_tie &&
      (is_free ? is_pressed(bodies, contacts, count, h) : are_trees_pressed(r, range, count, h));
  if (!calm && !pressed &&
      !(is_free && may_rest && count > kFewBodies && may_glide(bodies, contacts, count)))
    return;
  for (const GroupTree& t : std::span(r.trees).subspan(range.first_tree))
    if (t.from != t.to || t.held_spin != Vec3(0)) return;
  link_bodies(r, range, count);
  find_elimination_order(r, count);
  const std::size_t points = r.contacts.size() - range.first_contact + r.nodes.size() -
                             range.first_node + r.ties.size() - range.first_tie;
  const std::size_t rollings = r.rollings.size() - range.first_rolling;
  r.rest_rows.resize(range.first_resting + count);
  r.rest_marks.resize(range.first_mark + BlockPattern::scratch_of(count, points + rollings));
  const BlockPattern pattern{std::span(r.rest_rows).subspan(range.first_resting),
                             {},
                             std::span(r.rest_marks).subspan(range.first_mark)};
  const BlockPattern::Size size = pattern.size([&](auto&& visit) {
    for (std::uint32_t i = 0; i < count; ++i)
      for (std::uint32_t k = r.ends[i]; k < r.ends[i + 1]; ++k)
        if (r.links[k] < i) visit(r.numbered[i], r.numbered[r.links[k]]);
  });
  if (size.products > (calm || pressed ? kMostProducts * points : kMostGlidingProducts * count)) {
    r.rest_rows.resize(range.first_resting), r.rest_marks.resize(range.first_mark);
    return;
  }
  r.rest_columns.resize(range.first_column + size.blocks);
  for (std::size_t i = 0; i < count; ++i) {
    r.resting.emplace_back();
    r.resting.back().row = r.numbered[i];
  }
  add_links(r, range);
  range.pressed = pressed;
  r.numbers += kFactorWide * count + kFactorBlock * size.blocks;
}

}  // namespace pantin::detail::articulated
