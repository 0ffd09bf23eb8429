// Loads of contacts and stops by iteration: where it is not known beforehand which of them bear, or
// where two dynamic bodies touch. Every articulation tells how the places concerned answer to loads
// at each other, and projected Gauss-Seidel finds loads that suit all: contacts push and rub within
// their cone, stops push. Forces between bodies come in pairs, so momentum is kept whatever the
// iteration leaves. [Jourdan, Alart & Jean 1998]
#include <algorithm>

#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/articulated/articulated.hpp"

namespace pantin::articulated {
namespace {

/// Stops (rad) and contacts (part of the size) farther than this from being reached have no part
/// in a pass; one that is reached after all is heard in the next.
constexpr Real kNear = 0.01;

Vec3 across(Vec3 v, Vec3 n) { return v - glm::dot(v, n) * n; }

bool is_mutual(const World& world, const Touch& t) {
  return contact::feels_contacts(partition_of(world), contacts_of(world)[t.contact].slot_b);
}

void clear(StepScratch& r) {
  std::fill(r.forces_in.begin(), r.forces_in.end(), Loads{});
  std::fill(r.torques_in.begin(), r.torques_in.end(), Loads{});
}

/// A force at a touched point, a torque between the bodies of a joint.
void push_at(StepScratch& r, const Touch& t, Vec3 force, std::size_t side) {
  r.forces_in[t.column].add_to_side(side, force);
  r.torques_in[t.column].add_to_side(side, glm::cross(t.arm, force));
}
void push_between(const Island& a, StepScratch& r, std::size_t c, Vec3 torque,
                  std::size_t side) {
  r.torques_in[c].add_to_side(side, torque);
  if (a.parents[c] >= 0)
    r.torques_in[static_cast<std::size_t>(a.parents[c])].add_to_side(side, -torque);
}

/// Against which a stop pushes, and how far a joint has turned towards it.
Stop& stop_of(Island& a, const LoadRow& row) {
  return a.room.terms[row.column].stops[row.stop];
}

/// Room left at a contact with a fixed or driven body by the free answer, m.
Real clearance(const Island& a, const Touch& t, Vec3 normal) {
  return glm::dot(normal, moved_to(a, t) - t.goal);
}

/// Room left at a stop by the free answer, rad.
Real clearance(const Island& a, std::size_t c, const Stop& stop) {
  Vec3 relative = a.room.turn[c] - a.room.terms[c].align;
  if (a.parents[c] >= 0) relative -= a.room.turn[static_cast<std::size_t>(a.parents[c])];
  return stop.room - stop.bend - glm::dot(stop.along, relative);
}

void list_rows(const World& world, Island& a) {
  StepScratch& r = a.room;
  r.load_rows.clear();
  std::uint32_t number = 0;
  for (std::uint32_t i = 0; i < r.touches.size(); ++i) {
    Touch& t = r.touches[i];
    const Contact& contact = contacts_of(world)[t.contact];
    t.listed = false;
    if (!is_mutual(world, t) && contact.load == Vec3(0) &&
        clearance(a, t, contact.normal) > kNear * a.size)
      continue;
    t.listed = true;
    LoadRow row;
    row.touch = i, row.column = r.touches[i].column, row.number = number;
    r.load_rows.push_back(row);
    number += 3;
  }
  for (std::uint32_t c = 0; c < a.joints.size(); ++c) {
    if (!a.joints[c].stiff) continue;
    for (std::uint32_t s = 0; s < 4; ++s) {
      const Stop& stop = r.terms[c].stops[s];
      if (stop.along == Vec3(0) || stop.both_ways) continue;
      if (!(stop.load > 0) && clearance(a, c, stop) > kNear) continue;
      LoadRow row;
      row.is_stop = true, row.column = c, row.stop = s, row.number = number++;
      r.load_rows.push_back(row);
    }
  }
  r.load_moved.resize(number), r.load_response.resize(number * number);
}

/// Displacements that forces_in and torques_in, carried through the tree, stand for.
template <class Slide, class Turn>
void read_rows(const Island& a, Real* out, const Slide& slide, const Turn& turn) {
  const StepScratch& r = a.room;
  for (const LoadRow& row : r.load_rows) {
    if (!row.is_stop) {
      const Vec3 moved = slide(row.column) + glm::cross(turn(row.column), r.touches[row.touch].arm);
      for (int axis = 0; axis < 3; ++axis) out[row.number + static_cast<std::uint32_t>(axis)] = moved[axis];
      continue;
    }
    Vec3 relative = turn(row.column);
    if (a.parents[row.column] >= 0) relative -= turn(static_cast<std::size_t>(a.parents[row.column]));
    out[row.number] = glm::dot(r.terms[row.column].stops[row.stop].along, relative);
  }
}

void find_response(Island& a) {
  StepScratch& r = a.room;
  const std::size_t numbers = r.load_moved.size();
  const auto row_of = [&](std::size_t number, std::size_t& axis) -> const LoadRow& {
    auto row = std::upper_bound(
        r.load_rows.begin(), r.load_rows.end(), number,
        [](std::size_t n, const LoadRow& x) { return n < x.number; });
    --row;
    axis = number - row->number;
    return *row;
  };
  for (std::size_t first = 0; first < numbers; first += Loads::kSides) {
    const std::size_t sides = std::min(Loads::kSides, numbers - first);
    clear(r);
    for (std::size_t s = 0; s < sides; ++s) {
      std::size_t axis = 0;
      const LoadRow& row = row_of(first + s, axis);
      Vec3 unit(0);
      unit[static_cast<int>(axis)] = 1;
      if (row.is_stop)
        push_between(a, r, row.column, r.terms[row.column].stops[row.stop].along, s);
      else
        push_at(r, r.touches[row.touch], unit, s);
    }
    carry_up(a, r.forces_in, r.torques_in);
    carry_down(a, r.forces_in, r.torques_in);
    for (std::size_t s = 0; s < sides; ++s)
      read_rows(
          a, &r.load_response[(first + s) * numbers],
          [&](std::size_t c) { return r.forces_in[c].side(s); },
          [&](std::size_t c) { return r.torques_in[c].side(s); });
  }
}

Mat3 block(const Island& a, std::uint32_t of, std::uint32_t to) {
  const std::size_t n = a.room.load_moved.size();
  Mat3 m;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      m[static_cast<int>(i)][static_cast<int>(j)] = a.room.load_response[(to + i) * n + of + j];
  return m;
}

/// Moves every row of an articulation as a load of one number does.
void apply(Island& a, std::uint32_t number, Real load) {
  if (load == 0) return;
  const std::size_t n = a.room.load_moved.size();
  const Real* column = &a.room.load_response[number * n];
  Real* moved = a.room.load_moved.data();
  for (std::size_t i = 0; i < n; ++i) moved[i] += load * column[i];
}
void apply(Island& a, const LoadRow& row, Vec3 load) {
  for (std::uint32_t axis = 0; axis < 3; ++axis)
    apply(a, row.number + axis, load[static_cast<int>(axis)]);
}

Vec3 moved(const Island& a, const LoadRow& row) {
  const Real* m = &a.room.load_moved[row.number];
  return {m[0], m[1], m[2]};
}

/// Is this the half of a mutual contact that speaks for both?
bool speaks(const Island& a, const LoadRow& row) {
  return a.room.touches[row.touch].side > 0;
}

void start_contact(World& world, Island& a, LoadRow& row, Real h) {
  const Touch& t = a.room.touches[row.touch];
  Contact& c = contacts_of(world)[t.contact];
  Mat3 k = block(a, row.number, row.number);
  const Vec3 here = t.predicted + t.bend;
  if (row.other == UINT32_MAX) {
    row.wanted = t.goal - here;
  } else {
    const Island& b = islands_of(world)[row.other];
    const LoadRow& other = b.room.load_rows[row.other_row];
    const Touch& tb = b.room.touches[other.touch];
    k += block(b, other.number, other.number);
    if (&a == &b) k -= block(a, row.number, other.number) + block(a, other.number, row.number);
    // Out of the overlap along the normal; across it where it was when the step began.
    const Vec3 apart = here - (tb.predicted + tb.bend);
    const Vec3 before = to_world(world.bodies.values()[c.slot_a].pose, c.point_a) -
                        to_world(world.bodies.values()[c.slot_b].pose, c.point_b);
    const Real lift = h * std::max(Real(0), c.impact);
    row.wanted = (lift - glm::dot(apart, c.normal)) * c.normal - across(apart - before, c.normal);
  }
  const Real along = glm::dot(c.normal, k * c.normal);
  // At least what the softer direction across gives: a mean would overshoot in it.
  const Real aside = k[0][0] + k[1][1] + k[2][2] - along;
  // What hardly gives way cannot be moved by a load either.
  const Real least = 1e-6 / a.mass;
  row.stiffness = along > least ? 1 / along : 0;
  row.side_stiffness = aside > least ? 1 / aside : 0;
  apply(a, row, c.load);
  if (row.other != UINT32_MAX) {
    Island& b = islands_of(world)[row.other];
    apply(b, b.room.load_rows[row.other_row], -c.load);
  }
}

void start_stop(Island& a, LoadRow& row) {
  Stop& stop = stop_of(a, row);
  const std::size_t n = a.room.load_moved.size();
  const Real k = a.room.load_response[row.number * n + row.number];
  const Vec3 align = a.room.terms[row.column].align;
  row.wanted.x = stop.room - stop.bend + glm::dot(stop.along, align);
  const Mat3& give = a.room.joint_nodes[row.column].give;
  row.stiffness = k > 1e-6 * (give[0][0] + give[1][1] + give[2][2]) ? 1 / k : 0;
  apply(a, row.number, -stop.load);
}

/// One contact brought to where it belongs. Returns how far that moved it, m.
Real relax_contact(World& world, Island& a, const LoadRow& row) {
  Contact& c = contacts_of(world)[a.room.touches[row.touch].contact];
  Vec3 lack = row.wanted - moved(a, row);
  if (row.other != UINT32_MAX) {
    const Island& b = islands_of(world)[row.other];
    lack += moved(b, b.room.load_rows[row.other_row]);
  }
  const Real before = glm::dot(c.load, c.normal);
  const Real normal = std::max(Real(0), before + row.stiffness * glm::dot(lack, c.normal));
  Vec3 grip = across(c.load, c.normal) + row.side_stiffness * across(lack, c.normal);
  const Real most = c.friction * normal, held = glm::length(grip);
  c.sliding = held > most ? most / held : 1;
  grip *= c.sliding;
  Vec3 load = normal * c.normal + grip;
  if (!is_finite(load)) load = Vec3(0);
  const Vec3 change = load - c.load;
  c.load = load;
  if (change == Vec3(0)) return 0;
  apply(a, row, change);
  if (row.other != UINT32_MAX) {
    Island& b = islands_of(world)[row.other];
    apply(b, b.room.load_rows[row.other_row], -change);
  }
  return row.stiffness > 0 ? glm::length(change) / row.stiffness : 0;
}

/// The same for a stop, rad; its load counts against its direction.
Real relax_stop(Island& a, const LoadRow& row) {
  Stop& stop = stop_of(a, row);
  const Real beyond = a.room.load_moved[row.number] - row.wanted.x;
  const Real load = std::max(Real(0), stop.load + row.stiffness * beyond);
  const Real change = stop.load - load;
  apply(a, row.number, change);
  stop.load = load;
  return row.stiffness > 0 ? std::abs(change) / row.stiffness : 0;
}

/// Rows of mutual contacts find each other.
void pair_up(World& world, std::span<Island* const> all) {
  for (Island* a : all)
    for (LoadRow& row : a->room.load_rows) {
      if (row.is_stop || !speaks(*a, row)) continue;
      const Touch& t = a->room.touches[row.touch];
      if (!is_mutual(world, t)) continue;
      row.other = owner_of(partition_of(world), contacts_of(world)[t.contact].slot_b).island;
      const Island& b = islands_of(world)[row.other];
      for (std::uint32_t i = 0; i < b.room.load_rows.size(); ++i) {
        const LoadRow& other = b.room.load_rows[i];
        if (other.is_stop || speaks(b, other)) continue;
        if (b.room.touches[other.touch].contact == t.contact) row.other_row = i;
      }
    }
}

}  // namespace

void find_load_response(const World& world, Island& a) {
  list_rows(world, a);
  find_response(a);
  read_rows(
      a, a.room.load_moved.data(), [&](std::size_t c) { return a.room.slide[c]; },
      [&](std::size_t c) { return a.room.turn[c]; });
}

void iterate_loads(World& world, std::span<Island* const> all, Real h, int rounds,
                   Real enough) {
  pair_up(world, all);
  for (Island* a : all)
    for (LoadRow& row : a->room.load_rows) {
      if (row.is_stop)
        start_stop(*a, row);
      else if (speaks(*a, row))
        start_contact(world, *a, row, h);
    }
  for (int round = 0; round < rounds; ++round) {
    bool moved_any = false;
    for (Island* a : all) {
      Real most = 0;
      for (const LoadRow& row : a->room.load_rows) {
        if (row.is_stop)
          most = std::max(most, relax_stop(*a, row) * a->size);
        else if (speaks(*a, row))
          most = std::max(most, relax_contact(world, *a, row));
      }
      moved_any = moved_any || most > enough * a->size;
    }
    if (!moved_any) break;
  }
}

void add_iterated_loads(World& world, Island& a) {
  StepScratch& r = a.room;
  clear(r);
  for (const LoadRow& row : r.load_rows) {
    if (row.is_stop) {
      Stop& stop = stop_of(a, row);
      push_between(a, r, row.column, -stop.load * stop.along, 0);
      continue;
    }
    const Touch& t = r.touches[row.touch];
    push_at(r, t, t.side * contacts_of(world)[t.contact].load, 0);
  }
  add_loads(a);
}

}  // namespace pantin::articulated
