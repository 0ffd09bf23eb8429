// Contacts and limits by projected Gauss-Seidel: for active sets that guessing does not find, and
// for contacts between dynamic bodies. Every island provides the response between its rows
// (Delassus operator). The iteration enforces friction cones and unilateral limits. Forces come in
// equal and opposite pairs, so momentum is conserved even without convergence. [Jourdan, Alart &
// Jean 1998]
#include <algorithm>

#include "engine/base/invariants.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// Limits (rad) and contacts (relative to the size) with more clearance are left out; one that is
/// reached after all enters in the next iteration.
constexpr Real kCandidateDistance = 0.01;

Vec3 across(Vec3 v, Vec3 n) { return v - glm::dot(v, n) * n; }

bool is_mutual(const World& world, const ContactRow& t) {
  return is_own(world, contacts_of(world)[t.contact].slot_b);
}

void clear(StepScratch& r) {
  std::fill(r.forces_in.begin(), r.forces_in.end(), Vec3x4{});
  std::fill(r.torques_in.begin(), r.torques_in.end(), Vec3x4{});
}

/// A force at a contact point, or a torque between the bodies of a joint.
void push_at(StepScratch& r, const ContactRow& t, Vec3 force, std::size_t side) {
  PANTIN_ASSERT(t.column < r.forces_in.size());
  r.forces_in[t.column].add_to_side(side, force);
  r.torques_in[t.column].add_to_side(side, glm::cross(t.arm, force));
}
void push_between(Island& a, std::size_t c, Vec3 torque, std::size_t side) {
  StepScratch& r = a.scratch;
  PANTIN_ASSERT(c < r.torques_in.size());
  r.torques_in[c].add_to_side(side, torque);
  if (a.parents[c] >= 0)
    r.torques_in[static_cast<std::size_t>(a.parents[c])].add_to_side(side, -torque);
}

/// The limit of an iteration row.
LimitRow& limit_of(Island& a, const IterationRow& row) {
  PANTIN_ASSERT(row.is_limit && row.column < a.scratch.terms.size() && row.limit < 4);
  return a.scratch.terms[row.column].limits[row.limit];
}

/// Clearance of a contact with a fixed or kinematic body in the free response, m.
Real clearance(const Island& a, const ContactRow& t, Vec3 normal) {
  return glm::dot(normal, moved_to(a, t) - t.goal);
}

/// Clearance of a limit in the free response, rad.
Real clearance(const Island& a, std::size_t c, const LimitRow& limit) {
  Vec3 relative = a.scratch.rotation[c] - a.scratch.terms[c].align;
  if (a.parents[c] >= 0) relative -= a.scratch.rotation[static_cast<std::size_t>(a.parents[c])];
  return limit.clearance - limit.nonlinearity - glm::dot(limit.along, relative);
}

void list_rows(const World& world, Island& a) {
  StepScratch& r = a.scratch;
  r.iteration_rows.clear();
  std::uint32_t number = 0;
  for (std::uint32_t i = 0; i < r.contact_rows.size(); ++i) {
    ContactRow& t = r.contact_rows[i];
    const Contact& contact = contacts_of(world)[t.contact];
    t.listed = false;
    if (!is_mutual(world, t) && contact.lambda == Vec3(0) &&
        clearance(a, t, contact.normal) > kCandidateDistance * a.size)
      continue;
    t.listed = true;
    IterationRow row;
    row.contact_row = i, row.column = r.contact_rows[i].column, row.number = number;
    r.iteration_rows.push_back(row);
    number += 3;
  }
  for (std::uint32_t c = 0; c < a.joints.size(); ++c) {
    if (!a.joints[c].stiff) continue;
    for (std::uint32_t s = 0; s < 4; ++s) {
      const LimitRow& limit = r.terms[c].limits[s];
      if (limit.along == Vec3(0) || limit.both_ways) continue;
      if (!(limit.lambda > 0) && clearance(a, c, limit) > kCandidateDistance) continue;
      IterationRow row;
      row.is_limit = true, row.column = c, row.limit = s, row.number = number++;
      r.iteration_rows.push_back(row);
    }
  }
  r.contact_displacement.resize(number), r.contact_response.resize(number * number);
}

/// Row displacements for given translations and rotations of the bodies.
template <class Slide, class Turn>
void read_rows(const Island& a, Real* out, const Slide& translation, const Turn& rotation) {
  const StepScratch& r = a.scratch;
  for (const IterationRow& row : r.iteration_rows) {
    if (!row.is_limit) {
      const Vec3 moved = translation(row.column) +
                         glm::cross(rotation(row.column), r.contact_rows[row.contact_row].arm);
      for (int axis = 0; axis < 3; ++axis)
        out[row.number + static_cast<std::uint32_t>(axis)] = moved[axis];
      continue;
    }
    Vec3 relative = rotation(row.column);
    if (a.parents[row.column] >= 0)
      relative -= rotation(static_cast<std::size_t>(a.parents[row.column]));
    out[row.number] = glm::dot(r.terms[row.column].limits[row.limit].along, relative);
  }
}

void find_response(Island& a) {
  StepScratch& r = a.scratch;
  const std::size_t numbers = r.contact_displacement.size();
  const auto row_of = [&](std::size_t number, std::size_t& axis) -> const IterationRow& {
    auto row = std::upper_bound(r.iteration_rows.begin(), r.iteration_rows.end(), number,
                                [](std::size_t n, const IterationRow& x) { return n < x.number; });
    PANTIN_ASSERT(row != r.iteration_rows.begin());
    --row;
    axis = number - row->number;
    return *row;
  };
  PANTIN_ASSERT(r.contact_response.size() == numbers * numbers && r.forces_in.size() == a.count());
  for (std::size_t first = 0; first < numbers; first += Vec3x4::kSides) {
    const std::size_t sides = std::min(Vec3x4::kSides, numbers - first);
    clear(r);
    for (std::size_t s = 0; s < sides; ++s) {
      std::size_t axis = 0;
      const IterationRow& row = row_of(first + s, axis);
      Vec3 unit(0);
      unit[static_cast<int>(axis)] = 1;
      if (row.is_limit)
        push_between(a, row.column, r.terms[row.column].limits[row.limit].along, s);
      else
        push_at(r, r.contact_rows[row.contact_row], unit, s);
    }
    propagate_inward(a, r.forces_in, r.torques_in);
    propagate_outward(a, r.forces_in, r.torques_in);
    for (std::size_t s = 0; s < sides; ++s)
      read_rows(
          a, &r.contact_response[(first + s) * numbers],
          [&](std::size_t c) { return r.forces_in[c].side(s); },
          [&](std::size_t c) { return r.torques_in[c].side(s); });
  }
}

Mat3 block(const Island& a, std::uint32_t of, std::uint32_t to) {
  const std::size_t n = a.scratch.contact_displacement.size();
  PANTIN_ASSERT(of + 3 <= n && to + 3 <= n);
  Mat3 m;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      m[static_cast<int>(i)][static_cast<int>(j)] =
          a.scratch.contact_response[(to + i) * n + of + j];
  return m;
}

/// Adds the response of all rows of an island to a force along one row.
void apply(Island& a, std::uint32_t number, Real lambda) {
  if (lambda == 0) return;
  const std::size_t n = a.scratch.contact_displacement.size();
  PANTIN_ASSERT(number < n);
  const Real* column = &a.scratch.contact_response[number * n];
  Real* moved = a.scratch.contact_displacement.data();
  for (std::size_t i = 0; i < n; ++i) moved[i] += lambda * column[i];
}
void apply(Island& a, const IterationRow& row, Vec3 lambda) {
  for (std::uint32_t axis = 0; axis < 3; ++axis)
    apply(a, row.number + axis, lambda[static_cast<int>(axis)]);
}

Vec3 moved(const Island& a, const IterationRow& row) {
  PANTIN_ASSERT(!row.is_limit && row.number + 3 <= a.scratch.contact_displacement.size());
  const Real* m = &a.scratch.contact_displacement[row.number];
  return {m[0], m[1], m[2]};
}

/// Whether this row is the owner side of a contact between two dynamic bodies.
bool is_owner_side(const Island& a, const IterationRow& row) {
  PANTIN_ASSERT(!row.is_limit && row.contact_row < a.scratch.contact_rows.size());
  return a.scratch.contact_rows[row.contact_row].side > 0;
}

void start_contact(World& world, Island& a, IterationRow& row, Real h) {
  const ContactRow& t = a.scratch.contact_rows[row.contact_row];
  Contact& c = contacts_of(world)[t.contact];
  Mat3 k = block(a, row.number, row.number);
  const Vec3 here = t.predicted + t.nonlinearity;
  if (row.other == UINT32_MAX) {
    row.bias = t.goal - here;
  } else {
    const Island& b = islands_of(world)[row.other];
    PANTIN_ASSERT(row.other_row < b.scratch.iteration_rows.size());
    const IterationRow& other = b.scratch.iteration_rows[row.other_row];
    const ContactRow& tb = b.scratch.contact_rows[other.contact_row];
    k += block(b, other.number, other.number);
    if (&a == &b) k -= block(a, row.number, other.number) + block(a, other.number, row.number);
    // Normal: removes the penetration. Tangential: returns to the relative position at the start of
    // the step.
    const Vec3 apart = here - (tb.predicted + tb.nonlinearity);
    const Vec3 before = to_world(world.bodies.values()[c.slot_a].pose, c.point_a) -
                        to_world(world.bodies.values()[c.slot_b].pose, c.point_b);
    const Real lift = h * std::max(Real(0), c.impact);
    const Vec3 slip = apart - before + h * c.surface_velocity;
    row.bias = (lift - glm::dot(apart, c.normal)) * c.normal - across(slip, c.normal);
  }
  const Real along = glm::dot(c.normal, k * c.normal);
  PANTIN_ASSERT(is_unit(c.normal));
  // At least the compliance of the softer tangential direction: a mean would overshoot in it.
  const Real aside = k[0][0] + k[1][1] + k[2][2] - along;
  // A row without compliance cannot be moved by a force. The compliance may be negative: the
  // geometric stiffness of multipliers that were read from a file may be any.
  const Real least = 1e-6 / a.mass;
  row.stiffness = along > least ? 1 / along : 0;
  row.side_stiffness = aside > least ? 1 / aside : 0;
  apply(a, row, c.lambda);
  if (row.other != UINT32_MAX) {
    Island& b = islands_of(world)[row.other];
    apply(b, b.scratch.iteration_rows[row.other_row], -c.lambda);
  }
}

void start_stop(Island& a, IterationRow& row) {
  LimitRow& limit = limit_of(a, row);
  const std::size_t n = a.scratch.contact_displacement.size();
  const Real k = a.scratch.contact_response[row.number * n + row.number];
  const Vec3 align = a.scratch.terms[row.column].align;
  row.bias.x = limit.clearance - limit.nonlinearity + glm::dot(limit.along, align);
  const Mat3& compliance = a.scratch.joint_nodes[row.column].compliance;
  row.stiffness = k > 1e-6 * (compliance[0][0] + compliance[1][1] + compliance[2][2]) ? 1 / k : 0;
  apply(a, row.number, -limit.lambda);
}

/// What the iteration works on, looked up once: its inner loop does little else per contact.
struct Together {
  std::span<Contact> contacts;
  std::span<Island> islands;
};

/// One Gauss-Seidel update of a contact. Returns its displacement, m.
Real relax_contact(const Together& all, Island& a, const IterationRow& row) {
  Contact& c = all.contacts[a.scratch.contact_rows[row.contact_row].contact];
  Vec3 residual = row.bias - moved(a, row);
  if (row.other != UINT32_MAX) {
    const Island& b = all.islands[row.other];
    residual += moved(b, b.scratch.iteration_rows[row.other_row]);
  }
  const Real before = glm::dot(c.lambda, c.normal);
  const Real normal = std::max(Real(0), before + row.stiffness * glm::dot(residual, c.normal));
  Vec3 tangential = across(c.lambda, c.normal) + row.side_stiffness * across(residual, c.normal);
  const Real most = c.friction * normal, held = glm::length(tangential);
  c.sliding = held > most ? most / held : 1;
  tangential *= c.sliding;
  Vec3 lambda = normal * c.normal + tangential;
  if (!is_finite(lambda)) lambda = Vec3(0);
  const Vec3 change = lambda - c.lambda;
  c.lambda = lambda;
  if (change == Vec3(0)) return 0;
  apply(a, row, change);
  if (row.other != UINT32_MAX) {
    Island& b = all.islands[row.other];
    apply(b, b.scratch.iteration_rows[row.other_row], -change);
  }
  return row.stiffness > 0 ? glm::length(change) / row.stiffness : 0;
}

/// The same for a limit, rad; its lambda acts against its direction.
Real relax_stop(Island& a, const IterationRow& row) {
  LimitRow& limit = limit_of(a, row);
  const Real beyond = a.scratch.contact_displacement[row.number] - row.bias.x;
  const Real lambda = std::max(Real(0), limit.lambda + row.stiffness * beyond);
  const Real change = limit.lambda - lambda;
  apply(a, row.number, change);
  limit.lambda = lambda;
  return row.stiffness > 0 ? std::abs(change) / row.stiffness : 0;
}

/// Links the two rows of each contact between dynamic islands.
void pair_up(World& world, std::span<Island* const> all) {
  for (Island* a : all)
    for (IterationRow& row : a->scratch.iteration_rows) {
      if (row.is_limit || !is_owner_side(*a, row)) continue;
      const ContactRow& t = a->scratch.contact_rows[row.contact_row];
      if (!is_mutual(world, t)) continue;
      const std::uint32_t island =
          owner_of(partition_of(world), contacts_of(world)[t.contact].slot_b).island;
      PANTIN_ASSERT(island < islands_of(world).size());
      const Island& b = islands_of(world)[island];
      // An island that cannot be stepped takes no part: it is an obstacle.
      if (!b.finite) continue;
      for (std::uint32_t i = 0; i < b.scratch.iteration_rows.size(); ++i) {
        const IterationRow& other = b.scratch.iteration_rows[i];
        if (other.is_limit || is_owner_side(b, other)) continue;
        if (b.scratch.contact_rows[other.contact_row].contact == t.contact)
          row.other = island, row.other_row = i;
      }
    }
}

}  // namespace

void find_contact_response(const World& world, Island& a) {
  PANTIN_ASSERT(a.iterates && a.scratch.translation.size() == a.count());
  list_rows(world, a);
  find_response(a);
  read_rows(
      a, a.scratch.contact_displacement.data(),
      [&](std::size_t c) { return a.scratch.translation[c]; },
      [&](std::size_t c) { return a.scratch.rotation[c]; });
}

void iterate_contacts(World& world, std::span<Island* const> all, Real h,
                      const IterationBounds& until) {
  pair_up(world, all);
  for (Island* a : all)
    for (IterationRow& row : a->scratch.iteration_rows) {
      if (row.is_limit)
        start_stop(*a, row);
      else if (is_owner_side(*a, row))
        start_contact(world, *a, row, h);
    }
  const Together together{contacts_of(world), islands_of(world)};
  for (int round = 0; round < until.rounds; ++round) {
    bool moved_any = false;
    for (Island* a : all) {
      Real most = 0;
      for (const IterationRow& row : a->scratch.iteration_rows) {
        if (row.is_limit)
          most = std::max(most, relax_stop(*a, row) * a->size);
        else if (is_owner_side(*a, row))
          most = std::max(most, relax_contact(together, *a, row));
      }
      moved_any = moved_any || most > until.enough * a->size;
    }
    if (!moved_any) break;
  }
}

void add_iterated_lambdas(World& world, Island& a) {
  StepScratch& r = a.scratch;
  clear(r);
  for (const IterationRow& row : r.iteration_rows) {
    if (row.is_limit) {
      LimitRow& limit = limit_of(a, row);
      push_between(a, row.column, -limit.lambda * limit.along, 0);
      continue;
    }
    const ContactRow& t = r.contact_rows[row.contact_row];
    push_at(r, t, t.side * contacts_of(world)[t.contact].lambda, 0);
  }
  add_bias_lambdas(a);
}

}  // namespace pantin::detail::articulated
