// Mechanisms in a step of the plane: moved by RATTLE, or closed after Box2D's step if they have
// other contacts.
#include <algorithm>
#include <cmath>

#include "engine/solvers/planar/island.hpp"

namespace pantin::detail::planar {
namespace {

/// Adds the forces of a curve contact to the bodies, since Box2D does not know curves.
void press(Planar& all, const FlatCurve& c, const PlaceNow& at) {
  const CurvePlace& place = at.place;
  if (at.status != nurbs::ContactStatus::found) return;
  const Vec3 n = at.normal;
  const Vec3 force = place.force * n + place.along * Vec3(-n.y, n.x, 0);
  const auto give = [&](std::uint32_t body, Vec3 arm, Vec3 pull) {
    PANTIN_ASSERT(body < all.scratch.plane.bodies.size());
    PlaneBody& b = all.scratch.plane.bodies[body];
    if (b.kind != PlaneBody::dynamic) return;
    b.force += pull, b.torque += arm.x * pull.y - arm.y * pull.x;
  };
  give(c.a, at.arm_a, force), give(c.b, at.arm_b, -force);
}

/// Marks the mechanisms that are in contact with bodies.
void find_touched(Planar& all) {
  PANTIN_ASSERT(all.mechanism_of.size() == all.bodies.size() + 1);
  for (Mechanism& of : all.mechanisms) of.touched = false;
  for (const PlaneContact& t : all.touches)
    for (const std::uint32_t body : {t.a, t.b})
      if (const std::uint32_t at = all.mechanism_of[body]; at != kNobody)
        all.mechanisms[at].touched = true;
}

/// Leaves a mechanism out of Box2D's step if it has moved and has no outlines.
void leave_out(Planar& all, const Mechanism& of) {
  std::vector<PlaneBody>& bodies = all.scratch.plane.bodies;
  if (std::any_of(of.bodies.begin(), of.bodies.end(),
                  [&](std::uint32_t b) { return bodies[b].count > 0; }))
    return;
  for (const std::uint32_t b : of.bodies) bodies[b].kind = PlaneBody::absent;
}

/// Applies the forces of its curves in Box2D's step.
void press_curves(Planar& all, const Mechanism& of) {
  for (std::size_t i = 0; i < of.curves.size(); ++i) {
    FlatCurve& c = all.curves[of.curves[i]];
    for (std::size_t k = 0; k < c.most_places(); ++k) {
      CurvePlace& start = c.places[k];
      // With other contacts, the forces of the last step are the better estimate.
      if (of.moved && !c.struck)
        start.force = of.places[i][k].force, start.along = of.places[i][k].along;
      if (!start.used || c.over || (start.force == 0 && start.along == 0)) continue;
      PlaceNow at =
          of.moved ? of.starts[kMostPlaces * i + k] : follow(c, start, all.scratch.motions);
      at.place.force = start.force, at.place.along = start.along;
      press(all, c, at);
    }
  }
}

}  // namespace

void begin_motion(const PlaneBody& b, Real h, std::uint32_t number, Motions& m) {
  PANTIN_ASSERT(number < m.position.size() && m.gained.size() == m.position.size());
  m.position[number] = {b.position.x, b.position.y, b.angle};
  m.velocity[number] = m.inverse_mass[number] = Vec3(0), m.gained[number] = 0;
  if (b.kind == PlaneBody::fixed) return;
  m.velocity[number] = {b.velocity.x, b.velocity.y, b.spin};
  if (b.kind == PlaneBody::kinematic)
    m.position[number] -= h * m.velocity[number], m.gained[number] = -h * b.spin;
  else
    m.inverse_mass[number] = {1 / b.mass, 1 / b.mass, 1 / b.inertia};
}

void begin_motions(Planar& all, Real h) {
  Motions& m = all.scratch.motions;
  const std::vector<PlaneBody>& bodies = all.scratch.plane.bodies;
  for (auto* list : {&m.position, &m.velocity, &m.inverse_mass}) list->resize(bodies.size());
  m.gained.resize(bodies.size());
  for (std::uint32_t i = 0; i < bodies.size(); ++i) begin_motion(bodies[i], h, i, m);
}

void list_mechanisms(const World& world, Planar& all) {
  all.mechanisms.clear();
  all.mechanism_of.assign(all.bodies.size() + 1, kNobody);
  std::vector<std::uint32_t> of_island(all.islands, kNobody);
  const auto island_of = [&](std::uint32_t body) {
    return body == kNobody ? kNobody : all.bodies[body].island;
  };
  // The mechanism of a connection between two bodies; none if the solver moves neither.
  const auto owner = [&](std::uint32_t a, std::uint32_t b) -> Mechanism* {
    const std::uint32_t island = island_of(a) != kNobody ? island_of(a) : island_of(b);
    if (island == kNobody) return nullptr;
    if (of_island[island] == kNobody) {
      of_island[island] = static_cast<std::uint32_t>(all.mechanisms.size());
      all.mechanisms.emplace_back();
    }
    Mechanism& of = all.mechanisms[of_island[island]];
    for (const std::uint32_t body : {a, b}) {
      if (body == kNobody || island_of(body) != kNobody) continue;
      if (world.bodies.values()[all.bodies[body].slot].motion != Motion::kinematic) continue;
      if (std::find(of.driven.begin(), of.driven.end(), body) == of.driven.end())
        of.driven.push_back(body);
    }
    return &of;
  };
  for (std::uint32_t i = 0; i < all.curves.size(); ++i)
    if (Mechanism* of = owner(all.curves[i].a, all.curves[i].b)) of->curves.push_back(i);
  for (std::uint32_t i = 0; i < all.links.size(); ++i)
    if (Mechanism* of = owner(all.links[i].a, all.links[i].b)) of->links.push_back(i);
  for (std::uint32_t i = 0; i < all.pins.size(); ++i)
    if (Mechanism* of = owner(all.pins[i].body, all.pins[i].to)) of->pins.push_back(i);
  // A belt belongs to the mechanism of its first moving pulley.
  for (std::uint32_t i = 0; i < all.spans.size(); i += all.spans[i].held) {
    Mechanism* of = nullptr;
    PANTIN_ASSERT(all.spans[i].held > 0 && i + all.spans[i].held <= all.spans.size());
    for (std::uint32_t k = i; k < i + all.spans[i].held; ++k)
      if (Mechanism* found = owner(all.spans[k].a, all.spans[k].b); !of) of = found;
    for (std::uint32_t k = i; of && k < i + all.spans[i].held; ++k) of->spans.push_back(k);
  }
  for (std::uint32_t i = 0; i < all.gears.size(); ++i) {
    const FlatLink &one = all.links[all.gears[i].links[0]], &two = all.links[all.gears[i].links[1]];
    Mechanism* of = owner(one.a, one.b);
    if (!of) of = owner(two.a, two.b);
    if (of) of->gears.push_back(i);
  }
  for (std::uint32_t i = 0; i < all.drives.size(); ++i) {
    const FlatLink& link = all.links[all.drives[i].link];
    if (Mechanism* of = owner(link.a, link.b)) of->drives.push_back(i);
  }
  for (std::uint32_t i = 0; i < all.bodies.size(); ++i) {
    const std::uint32_t island = all.bodies[i].island;
    if (island == kNobody || of_island[island] == kNobody) continue;
    all.mechanism_of[i] = of_island[island];
    all.mechanisms[of_island[island]].bodies.push_back(i);
  }
}

void move_mechanisms(const World& world, Planar& all, Real h) {
  find_touched(all);
  for (Mechanism& of : all.mechanisms) {
    of.moved = false, of.row_impulses.clear();
    for (const std::uint32_t curve : of.curves)
      if (!all.curves[curve].over) search_places(all.curves[curve], all.scratch.motions);
    // A mechanism with contacts will most likely have them again.
    if (!of.touched || !of.curves.empty()) move_by_rattle(world, all, of, h);
    if (of.moved) leave_out(all, of);
  }
  for (const Mechanism& of : all.mechanisms) press_curves(all, of);
}

void take_mechanisms(Planar& all) {
  Motions& m = all.scratch.motions;
  find_touched(all);
  for (Mechanism& of : all.mechanisms) {
    of.moved = of.moved && !of.touched;
    for (const std::uint32_t curve : of.curves) all.curves[curve].struck = !of.moved;
    if (!of.moved) continue;
    all.residual = std::max(all.residual, of.residual);
    for (std::size_t i = 0; i < of.bodies.size(); ++i) {
      PANTIN_ASSERT(of.position.size() == of.bodies.size() &&
                    of.velocity.size() == of.bodies.size());
      const std::uint32_t b = of.bodies[i];
      m.gained[b] = of.position[i].z - all.scratch.plane.bodies[b].angle;
      m.position[b] = of.position[i], m.velocity[b] = of.velocity[i];
    }
    std::size_t joint = 0;
    each_joint(all, of, [&](PlaneJoint& j) { j.load = of.borne[joint++]; });
    for (std::size_t i = 0; i < of.spans.size(); ++i) {
      FlatSpan& span = all.spans[of.spans[i]];
      span.impulse = of.span_loads[i].impulse, span.slips = of.span_loads[i].slips;
    }
    for (std::size_t i = 0; i < of.curves.size(); ++i) {
      FlatCurve& c = all.curves[of.curves[i]];
      c.places = of.places[i], c.searched = of.searched[i];
    }
  }
}

void append_curve_rows(Planar& all, const Mechanism& of, std::vector<Row>& rows) {
  StepScratch& s = all.scratch;
  s.first_curve_row = rows.size();
  for (const std::uint32_t i : of.curves) {
    FlatCurve& c = all.curves[i];
    for (std::size_t k = 0; k < c.most_places(); ++k) {
      PlaceNow& now = s.nows[kMostPlaces * i + k];
      now = {};
      CurvePlace& place = c.places[k];
      if (place.used && !c.over) now = follow(c, place, s.motions);
      const bool found = now.status == nurbs::ContactStatus::found;
      if (found) place = now.place;
      if (found && c.lifts && now.gap < 0) place.presses = true;
      const bool holds = found && (!c.lifts || place.presses);
      append_place_rows(c, holds ? &now : nullptr, rows);
    }
  }
}

void take_curve_impulses(Planar& all, const Mechanism& of, Real h) {
  StepScratch& s = all.scratch;
  std::size_t row = s.first_curve_row;
  const auto act = [&](std::size_t r, Real& force) {
    const Row& by = s.rows[r];
    force += s.lambda[r] / (h * h);
    for (int i = 0; i < by.count; ++i)
      s.motions.velocity[by.body[i]] +=
          s.motions.inverse_mass[by.body[i]] * (s.lambda[r] / h * by.j[i]);
  };
  for (const std::uint32_t i : of.curves) {
    FlatCurve& c = all.curves[i];
    for (std::size_t k = 0; k < c.most_places(); ++k, row += c.rows_per_place()) {
      CurvePlace& place = c.places[k];
      if (!place.used || c.over) continue;
      if (c.lifts && place.force + s.lambda[row] / (h * h) < 0) {
        s.lambda[row] = -place.force * h * h;
        if (c.rolls) s.lambda[row + 1] = 0;
        act(row, place.force), place.force = 0, place.presses = false;
        continue;
      }
      act(row, place.force);
      if (c.rolls) act(row + 1, place.along);
    }
  }
}

void find_lost_curves(const World& world, Planar& all) {
  for (const Mechanism& of : all.mechanisms)
    for (const std::uint32_t i : of.curves) {
      FlatCurve& c = all.curves[i];
      for (std::size_t k = 0; k < c.most_places() && !of.moved && !c.over; ++k) {
        const PlaceNow& now = all.scratch.nows[kMostPlaces * i + k];
        CurvePlace& place = c.places[k];
        const bool is_held = !c.lifts || (place.used && place.presses);
        if (now.status == nurbs::ContactStatus::found) continue;
        place.presses = place.used = false, place.force = place.along = 0;
        if (!is_held) continue;
        if (world.surface_contacts.values()[c.contact].on_rim == OnRim::release) {
          c.over = true, c.how = now.status;
          continue;
        }
        all.lost_contact = c.owner, all.lost_how = now.status;
        all.lost = all.bodies[all.mechanism_of[c.a] != kNobody ? c.a : c.b].body;
      }
    }
}

void write_curves(World& world, Planar& all) {
  Motions& m = all.scratch.motions;
  for (const Mechanism& of : all.mechanisms)
    for (std::size_t i = 0; i < of.curves.size(); ++i) {
      PlaceNow* nows = &all.scratch.nows[kMostPlaces * of.curves[i]];
      const FlatCurve& c = all.curves[of.curves[i]];
      for (std::size_t k = 0; k < c.most_places(); ++k)
        nows[k] = of.moved ? of.ends[kMostPlaces * i + k] : follow(c, c.places[k], m);
    }
  for (FlatCurve& c : all.curves) {
    SurfaceContact& to = world.surface_contacts.values()[c.contact];
    const CurvePlace* best = nullptr;
    PlaceNow at;
    to.force = Vec3(0), to.touches = false;
    for (std::size_t k = 0; k < c.most_places(); ++k) {
      const CurvePlace& place = c.places[k];
      if (!place.used || c.over) continue;
      const auto number = static_cast<std::size_t>(&c - all.curves.data());
      const PlaceNow& now = all.scratch.nows[kMostPlaces * number + k];
      if (now.status != nurbs::ContactStatus::found) continue;
      const Vec3 n = now.normal;
      to.force -= place.force * n + place.along * Vec3(-n.y, n.x, 0);
      to.touches = to.touches || !c.lifts || place.presses;
      if (best && (place.presses < best->presses ||
                   (place.presses == best->presses && std::abs(now.gap) >= std::abs(at.gap))))
        continue;
      best = &place, at = now;
    }
    to.over = c.over, to.status = c.over ? c.how : nurbs::ContactStatus::found;
    to.known = best != nullptr;
    if (!best) continue;
    const Real height = world.bodies[to.b].pose.position.z +
                        (world.bodies[to.b].pose.rotation * to.on_b.pose.position).z;
    to.at = {{0, best->t_a, 0}, {0, best->t_b, 0}};
    to.point = Vec3(m.position[c.b].x, m.position[c.b].y, height) + at.arm_b;
    to.normal = at.normal, to.gap = at.gap;
  }
}

}  // namespace pantin::detail::planar
