// Contacts between dynamic bodies, of one articulation or of several: every articulation tells how
// it answers to loads at the points where it is touched, and projected Gauss-Seidel finds loads
// that suit all of them. Forces come in pairs, so momentum is kept whatever the iteration leaves.
#include <algorithm>

#include "engine/solvers/procedural/internal.hpp"
#include "engine/solvers/procedural/procedural.hpp"

namespace pantin::procedural {
namespace {

constexpr int kRounds = 60;
constexpr Real kEnough = 1e-9;  // change of a load, part of the largest

Vec3 across(Vec3 v, Vec3 n) { return v - glm::dot(v, n) * n; }

bool is_mutual(const World& world, const Touch& t) {
  const Body& b = world.bodies.values()[world.contacts[t.contact].slot_b];
  return b.motion == Motion::dynamic;
}

void clear(StepRoom& r) {
  std::fill(r.forces_in.begin(), r.forces_in.end(), Loads{});
  std::fill(r.torques_in.begin(), r.torques_in.end(), Loads{});
}

void push(StepRoom& r, const Touch& t, Vec3 load, std::size_t side) {
  r.forces_in[t.column].add_to_side(side, load);
  r.torques_in[t.column].add_to_side(side, glm::cross(t.arm, load));
}

/// Lists the contacts of the World with the places of their two points, in the order of contacts.
void list_contacts(World& world) {
  std::vector<MutualContact>& list = world.touch_room.mutual;
  list.clear();
  for (std::uint32_t i = 0; i < world.articulations.size(); ++i) {
    const Articulation& a = world.articulations[i];
    if (!a.mutual) continue;
    for (std::uint32_t n = 0; n < a.room.mutual.size(); ++n) {
      const Touch& t = a.room.touches[a.room.mutual[n]];
      MutualContact m;
      m.contact = t.contact;
      if (t.side > 0)
        m.a = i, m.place_a = n, m.b = UINT32_MAX;
      else
        m.b = i, m.place_b = n, m.a = UINT32_MAX;
      list.push_back(m);
    }
  }
  std::stable_sort(list.begin(), list.end(), [](const MutualContact& x, const MutualContact& y) {
    return x.contact != y.contact ? x.contact < y.contact : x.b == UINT32_MAX && y.b != UINT32_MAX;
  });
  // Pairs of halves become wholes.
  std::size_t made = 0;
  for (std::size_t i = 0; i + 1 < list.size(); i += 2) {
    MutualContact m = list[i];
    m.b = list[i + 1].b, m.place_b = list[i + 1].place_b;
    list[made++] = m;
  }
  list.resize(made);
}

const Mat3& response(const Articulation& a, std::uint32_t of, std::uint32_t to) {
  return a.room.mutual_response[of * a.room.mutual.size() + to];
}

/// Moves every touched point of an articulation as a load at one of them does.
void apply(Articulation& a, std::uint32_t at, Vec3 load) {
  for (std::uint32_t n = 0; n < a.room.mutual.size(); ++n)
    a.room.mutual_moved[n] += response(a, n, at) * load;
}

void apply(World& world, const MutualContact& m, Vec3 load) {
  apply(world.articulations[m.a], m.place_a, load);
  apply(world.articulations[m.b], m.place_b, -load);
}

void prepare(World& world, MutualContact& m, Real h) {
  const Articulation &a = world.articulations[m.a], &b = world.articulations[m.b];
  Contact& c = world.contacts[m.contact];
  const Touch &ta = a.room.touches[a.room.mutual[m.place_a]],
              &tb = b.room.touches[b.room.mutual[m.place_b]];
  // Out of the overlap along the normal; across it where it was when the step began.
  const Vec3 apart = (ta.predicted + ta.bend) - (tb.predicted + tb.bend);
  const Vec3 before = to_world(world.bodies.values()[c.slot_a].pose, c.point_a) -
                      to_world(world.bodies.values()[c.slot_b].pose, c.point_b);
  const Real lift = h * std::max(Real(0), c.impact);
  m.wanted = (lift - glm::dot(apart, c.normal)) * c.normal - across(apart - before, c.normal);
  Mat3 k = response(a, m.place_a, m.place_a) + response(b, m.place_b, m.place_b);
  if (m.a == m.b) k -= response(a, m.place_a, m.place_b) + response(a, m.place_b, m.place_a);
  const Real along = glm::dot(c.normal, k * c.normal);
  const Real aside = 0.5 * (k[0][0] + k[1][1] + k[2][2] - along);
  m.stiffness = along > 0 ? 1 / along : 0;
  m.side_stiffness = aside > 0 ? 1 / aside : 0;
}

/// One contact brought to where it belongs. Returns the change of its load.
Real relax_contact(World& world, const MutualContact& m) {
  Articulation &a = world.articulations[m.a], &b = world.articulations[m.b];
  Contact& c = world.contacts[m.contact];
  const Vec3 lack =
      m.wanted - (a.room.mutual_moved[m.place_a] - b.room.mutual_moved[m.place_b]);
  const Real before = glm::dot(c.load, c.normal);
  const Real normal = std::max(Real(0), before + m.stiffness * glm::dot(lack, c.normal));
  Vec3 grip = across(c.load, c.normal) + m.side_stiffness * across(lack, c.normal);
  const Real most = c.friction * normal, held = glm::length(grip);
  c.sliding = held > most ? most / held : 1;
  grip *= c.sliding;
  const Vec3 load = normal * c.normal + grip, change = load - c.load;
  c.load = load;
  apply(world, m, change);
  return glm::length(change);
}

}  // namespace

void find_mutual_response(World& world, Articulation& a) {
  StepRoom& r = a.room;
  r.mutual.clear();
  for (std::uint32_t i = 0; i < r.touches.size(); ++i)
    if (is_mutual(world, r.touches[i])) r.mutual.push_back(i);
  const std::size_t n = r.mutual.size();
  r.mutual_moved.resize(n), r.mutual_response.resize(n * n);
  for (std::size_t i = 0; i < n; ++i) {
    const Touch& t = r.touches[r.mutual[i]];
    r.mutual_moved[i] = r.slide[t.column] + glm::cross(r.turn[t.column], t.arm);
  }
  for (std::size_t to = 0; to < n; ++to) {
    clear(r);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Vec3 unit(0);
      unit[static_cast<int>(axis)] = 1;
      push(r, r.touches[r.mutual[to]], unit, axis);
    }
    carry_up(a, r.forces_in, r.torques_in);
    carry_down(a, r.forces_in, r.torques_in);
    for (std::size_t of = 0; of < n; ++of) {
      const Touch& t = r.touches[r.mutual[of]];
      for (std::size_t axis = 0; axis < 3; ++axis)
        r.mutual_response[of * n + to][static_cast<int>(axis)] =
            r.forces_in[t.column].side(axis) +
            glm::cross(r.torques_in[t.column].side(axis), t.arm);
    }
  }
}

void solve_mutual(World& world, Real h) {
  list_contacts(world);
  std::vector<MutualContact>& list = world.touch_room.mutual;
  for (MutualContact& m : list) {
    prepare(world, m, h);
    apply(world, m, world.contacts[m.contact].load);
  }
  for (int round = 0; round < kRounds; ++round) {
    Real change = 0, largest = 0;
    for (const MutualContact& m : list) {
      change = std::max(change, relax_contact(world, m));
      largest = std::max(largest, glm::length(world.contacts[m.contact].load));
    }
    if (!(change > kEnough * largest)) break;
  }
  for (const MutualContact& m : list) {
    Contact& c = world.contacts[m.contact];
    c.active = glm::dot(c.load, c.normal) > 0, c.force = c.load;
  }
}

void add_mutual_loads(const World& world, Articulation& a) {
  StepRoom& r = a.room;
  clear(r);
  for (std::uint32_t i : r.mutual) {
    const Touch& t = r.touches[i];
    push(r, t, t.side * world.contacts[t.contact].load, 0);
  }
  add_loads(a);
}

}  // namespace pantin::procedural
