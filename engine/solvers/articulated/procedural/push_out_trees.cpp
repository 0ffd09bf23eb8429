// Penetration removal by the rules of the paper: translates overlapping bodies out along the
// normals, and closes their joints again. [Lee 2000, sec. 4.2]
#include <algorithm>

#include "engine/contact/contact.hpp"
#include "engine/contact/detect.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/procedural/push_out.hpp"
#include "engine/solvers/articulated/procedural/sweeps.hpp"

namespace pantin::detail::articulated {
namespace {

/// Most of an initial overlap that a step removes, as a fraction of the island's size: the whole
/// displacement becomes velocity.
constexpr Real kShallowOverlap = 5e-3;
/// Iterations end once bodies move by less than this fraction of the island's size.
constexpr Real kPushedOut = 1e-6;
/// Gap up to which a point touches, as a fraction of the size.
constexpr Real kTouching = 1e-12;

/// The touching point of a body at its final pose: one radius below the core of a round shape, at
/// any rotation.
Vec3 touching_point(const World& world, const Island& a, const ContactRow& row) {
  const Contact& c = contacts_of(world)[row.contact];
  const Quat before = world.bodies.values()[a.slots[row.column]].pose.rotation;
  const auto on = contact::touched_place(world, c, {contact::BodyOfContact::Side::a, before});
  const LaneTable& work = a.scratch.work;
  return work.vec(kFinalPosition, row.column) +
         on.at(work.quat(kFinalRotation, row.column), -c.normal);
}

/// A contact point of a body at the final poses.
struct Touch {
  Real depth = 0;  // m, to be removed
  Vec3 slip{0};    // m, relative to the other body since the start of the step
};

Touch touch_of(const World& world, const Island& a, const ContactRow& row, Real h) {
  const Contact& c = contacts_of(world)[row.contact];
  const Vec3 on_a = point_at(a, row.column, c.point_a, kFinalPoses);
  const Vec3 on_b = point_on(world, c.slot_b, c.point_b);
  const Real depth = glm::dot(c.normal, on_b - touching_point(world, a, row));
  const Real left = std::max(Real(0), -c.gap - kShallowOverlap * a.size);
  const Vec3 slip = on_a - point_on(world, a.slots[row.column], c.point_a) -
                    (on_b - point_before(world, c.slot_b, c.point_b, h)) + h * c.surface_velocity;
  return {depth - left, slip - glm::dot(slip, c.normal) * c.normal};
}

/// The contacts of one body; the rows are sorted by body.
std::span<const ContactRow> rows_of(const Island& a, std::size_t column) {
  const std::vector<ContactRow>& rows = a.scratch.contact_rows;
  const auto before = [](const ContactRow& row, std::size_t c) { return row.column < c; };
  const auto first = std::lower_bound(rows.begin(), rows.end(), column, before);
  return {first, std::lower_bound(first, rows.end(), column + 1, before)};
}

/// Translates a body out of its overlaps, and back against its slip by friction: at most `friction`
/// times the distance out, over all iterations. Returns how far it moved, m.
Real push_body(const World& world, Island& a, std::size_t column, Real h) {
  HalfSpaces planes;
  Vec3 slip(0);
  Real deepest = -kTooFar, friction = 0;
  int touching = 0;
  PANTIN_ASSERT(column < a.scratch.pushes.size());
  BodyPush& push = a.scratch.pushes[column];
  for (const ContactRow& row : rows_of(a, column)) {
    const Contact& c = contacts_of(world)[row.contact];
    if (is_own(world, c.slot_b)) continue;
    const Touch touch = touch_of(world, a, row, h);
    if (touch.depth < -kTouching * a.size) continue;
    planes.add(c.normal, touch.depth);
    slip += touch.slip, ++touching;
    if (touch.depth > deepest) deepest = touch.depth, friction = c.friction;
  }
  if (touching == 0) return 0;
  Vec3 way = push_out(planes);
  push.out += glm::length(way), push.way += way;
  const Vec3 all = push.held - slip / Real(touching);
  const Real length = glm::length(all), most = friction * push.out;
  const Vec3 held = length > most ? most / length * all : all;
  way += held - push.held;
  push.held = held;
  a.scratch.work.set(kFinalPosition, column, a.scratch.work.vec(kFinalPosition, column) + way);
  return glm::length(way);
}

/// From the leaves to the root: pushes bodies out, and moves their parents along. Returns the
/// longest displacement, m.
Real push_inwards(const World& world, Island& a, const Tree& tree, Real h) {
  Real longest = 0;
  const std::size_t end = tree.first + tree.count;
  std::vector<std::uint8_t>& leads = a.scratch.on_path;
  PANTIN_ASSERT(end <= leads.size());
  std::fill(leads.begin() + tree.first, leads.begin() + static_cast<std::ptrdiff_t>(end),
            std::uint8_t(0));
  for (std::size_t c = end; c-- > tree.first;) {
    const Real way = push_body(world, a, c, h);
    longest = std::max(longest, way);
    if (way > 0) leads[c] = 1;
    if (leads[c] == 0) continue;
    if (a.parents[c] < 0) continue;
    lead_parent(a, c);
    leads[static_cast<std::size_t>(a.parents[c])] = 1;
  }
  return longest;
}

/// Distributes the force that would translate a body so within a step, mass * displacement / h^2,
/// among the contacts that pushed it: the displacement along normals in proportion to each
/// contact's component, friction equally. Displacements by joints are not counted.
void share_push(World& world, const Island& a, std::span<const ContactRow> rows, Real h) {
  const std::size_t column = rows.front().column;
  const BodyPush& push = a.scratch.pushes[column];
  std::vector<Contact>& contacts = contacts_of(world);
  // A contact in which this is body b is reported by the island of body a.
  const auto pushed = [&](const ContactRow& row) {
    return row.side > 0 && contacts[row.contact].active;
  };
  const auto opposes = [&](const Contact& c) {
    return std::max(Real(0), glm::dot(c.normal, push.way));
  };
  Real shares = 0, pushing = 0;
  for (const ContactRow& row : rows) {
    if (!pushed(row)) continue;
    const Real share = opposes(contacts[row.contact]);
    shares += share * share, ++pushing;
  }
  if (!(shares > 0)) return;
  const Real to_force = world.bodies.values()[a.slots[column]].mass / (h * h);
  for (const ContactRow& row : rows) {
    if (!pushed(row)) continue;
    Contact& c = contacts[row.contact];
    const Vec3 out = glm::dot(push.way, push.way) * opposes(c) / shares * c.normal;
    c.force = to_force * (out + push.held / pushing);
  }
}

/// Reports the remaining overlaps, the active contacts and their forces.
void report_push(World& world, const Island& a, Real h) {
  const std::span<const ContactRow> rows = a.scratch.contact_rows;
  for (const ContactRow& row : rows) {
    if (row.side < 0) continue;
    Contact& c = contacts_of(world)[row.contact];
    const Vec3 on_b = point_on(world, c.slot_b, c.point_b);
    const Vec3 on_a = touching_point(world, a, row);
    c.depth = std::max(Real(0), glm::dot(c.normal, on_b - on_a)), c.force = c.torque = Vec3(0);
    c.active = !is_own(world, c.slot_b) && a.scratch.pushes[row.column].out > 0 &&
               touch_of(world, a, row, h).depth >= -kPushedOut * a.size;
  }
  for (std::size_t i = 0; i < rows.size();) {
    const std::span<const ContactRow> body = rows_of(a, rows[i].column);
    share_push(world, a, body, h);
    i += body.size();
  }
}

}  // namespace

void push_out_trees(World& world, Island& a, Real h) {
  std::vector<ContactRow>& rows = a.scratch.contact_rows;
  std::sort(rows.begin(), rows.end(), [](const ContactRow& x, const ContactRow& y) {
    return x.column != y.column ? x.column < y.column : x.contact < y.contact;
  });
  PANTIN_ASSERT(a.scratch.pushes.size() == a.count());
  std::fill(a.scratch.pushes.begin(), a.scratch.pushes.end(), BodyPush{});
  for (int round = 0; round < a.settings.sweeps; ++round) {
    Real longest = 0;
    for (const Tree& tree : a.trees) longest = std::max(longest, push_inwards(world, a, tree, h));
    if (longest == 0) break;
    if (has_rows(a))
      relax(world, a);
    else
      sweep_closed(world, a);
    if (longest <= kPushedOut * a.size) break;
  }
  report_push(world, a, h);
}

}  // namespace pantin::detail::articulated
