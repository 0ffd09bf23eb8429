// Mechanisms of curves in a step of the plane: moved by RATTLE, or closed after Box2D's step where
// something else touches them.
#include <algorithm>
#include <cmath>

#include "engine/solvers/planar/island.hpp"

namespace pantin::detail::planar {
namespace {

/// All bodies where the step begins.
void begin_motions(Planar& all, Real h) {
  StepScratch& s = all.scratch;
  Motions& m = s.motions;
  const std::size_t count = s.plane.bodies.size();
  m.position.assign(count, Vec3(0)), m.velocity = m.inverse_mass = m.position;
  m.gained.assign(count, 0);
  for (std::uint32_t i = 0; i < count; ++i) begin_motion(s.plane.bodies[i], h, i, m);
}

/// The plane's step is taken under the forces of curves, which it does not know.
void press(Planar& all, const FlatCurve& c, const PlaceNow& at) {
  const CurvePlace& place = at.place;
  if (at.status != nurbs::ContactStatus::found) return;
  const Vec3 n = at.normal;
  const Vec3 force = place.force * n + place.along * Vec3(-n.y, n.x, 0);
  const auto give = [&](std::uint32_t body, Vec3 arm, Vec3 pull) {
    PlaneBody& b = all.scratch.plane.bodies[body];
    if (b.kind != PlaneBody::dynamic) return;
    b.force += pull, b.torque += arm.x * pull.y - arm.y * pull.x;
  };
  give(c.a, at.arm_a, force), give(c.b, at.arm_b, -force);
}

}  // namespace

void list_mechanisms(const World& world, Planar& all) {
  all.mechanisms.clear();
  all.mechanism_of.assign(all.bodies.size() + 1, kNobody);
  std::vector<std::uint32_t> of_island(all.islands, kNobody);
  for (std::uint32_t i = 0; i < all.curves.size(); ++i) {
    std::uint32_t& at = of_island[all.curves[i].island];
    if (at == kNobody)
      at = static_cast<std::uint32_t>(all.mechanisms.size()), all.mechanisms.emplace_back();
    all.mechanisms[at].curves.push_back(i);
  }
  for (std::uint32_t i = 0; i < all.bodies.size(); ++i) {
    const std::uint32_t island = all.bodies[i].island;
    if (island == kNobody || of_island[island] == kNobody) continue;
    all.mechanism_of[i] = of_island[island];
    all.mechanisms[of_island[island]].bodies.push_back(i);
  }
  const auto drive = [&](std::uint32_t mechanism, std::uint32_t body) {
    std::vector<std::uint32_t>& list = all.mechanisms[mechanism].driven;
    if (body == kNobody || all.mechanism_of[body] == mechanism) return;
    if (world.bodies.values()[all.bodies[body].slot].motion != Motion::kinematic) return;
    if (std::find(list.begin(), list.end(), body) == list.end()) list.push_back(body);
  };
  for (std::uint32_t i = 0; i < all.mechanisms.size(); ++i)
    for (const std::uint32_t curve : all.mechanisms[i].curves)
      drive(i, all.curves[curve].a), drive(i, all.curves[curve].b);
  const auto owner = [&](std::uint32_t a, std::uint32_t b) {
    const std::uint32_t at = all.mechanism_of[a];
    return at != kNobody || b == kNobody ? at : all.mechanism_of[b];
  };
  for (std::uint32_t i = 0; i < all.links.size(); ++i)
    if (const auto at = owner(all.links[i].a, all.links[i].b); at != kNobody) {
      all.mechanisms[at].links.push_back(i);
      drive(at, all.links[i].a), drive(at, all.links[i].b);
    }
  for (std::uint32_t i = 0; i < all.pins.size(); ++i)
    if (const auto at = owner(all.pins[i].body, all.pins[i].to); at != kNobody) {
      all.mechanisms[at].pins.push_back(i);
      drive(at, all.pins[i].to);
    }
  for (const FlatSpan& span : all.spans)
    if (const auto at = owner(span.a, span.b); at != kNobody) all.mechanisms[at].has_belt = true;
  for (std::uint32_t i = 0; i < all.gears.size(); ++i)
    for (const std::uint32_t link : all.gears[i].links) {
      const auto at = owner(all.links[link].a, all.links[link].b);
      if (at == kNobody) continue;
      all.mechanisms[at].gears.push_back(i);
      break;
    }
}

void move_mechanisms(const World& world, Planar& all, Real h) {
  if (all.curves.empty()) return;
  begin_motions(all, h);
  for (Mechanism& of : all.mechanisms) {
    of.moved = false;
    for (const std::uint32_t curve : of.curves)
      if (!all.curves[curve].over) search_places(all.curves[curve], all.scratch.motions);
    if (!of.has_belt) move_by_rattle(world, all, of, h);
  }
  for (const Mechanism& of : all.mechanisms)
    for (std::size_t i = 0; i < of.curves.size(); ++i) {
      FlatCurve& c = all.curves[of.curves[i]];
      for (std::size_t k = 0; k < c.most_places(); ++k) {
        CurvePlace& start = c.places[k];
        // What something else bears, the last step knows better.
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

void take_mechanisms(Planar& all) {
  if (all.curves.empty()) return;
  Motions& m = all.scratch.motions;
  for (const Touch& t : all.touches)
    for (const std::uint32_t body : {t.a, t.b})
      if (const std::uint32_t at = all.mechanism_of[body]; at != kNobody)
        all.mechanisms[at].moved = false;
  for (const Mechanism& of : all.mechanisms) {
    for (const std::uint32_t curve : of.curves) all.curves[curve].struck = !of.moved;
    if (!of.moved) continue;
    all.residual = std::max(all.residual, of.residual);
    for (std::size_t i = 0; i < of.bodies.size(); ++i) {
      const std::uint32_t b = of.bodies[i];
      m.gained[b] = of.position[i].z - all.scratch.plane.bodies[b].angle;
      m.position[b] = of.position[i], m.velocity[b] = of.velocity[i];
    }
    for (std::size_t i = 0; i < of.curves.size(); ++i) {
      FlatCurve& c = all.curves[of.curves[i]];
      c.places = of.places[i], c.searched = of.searched[i];
    }
  }
}

bool is_closed_already(const Planar& all) {
  std::size_t links = 0, pins = 0, gears = 0;
  for (const Mechanism& of : all.mechanisms) {
    if (!of.moved) return false;
    links += of.links.size(), pins += of.pins.size(), gears += of.gears.size();
  }
  return !all.mechanisms.empty() && all.spans.empty() && links == all.links.size() &&
         pins == all.pins.size() && gears == all.gears.size();
}

void append_curve_rows(Planar& all, std::vector<Row>& rows) {
  StepScratch& s = all.scratch;
  s.first_curve_row = rows.size(), s.nows.assign(kMostPlaces * all.curves.size(), {});
  for (const Mechanism& of : all.mechanisms)
    for (const std::uint32_t i : of.curves) {
      FlatCurve& c = all.curves[i];
      for (std::size_t k = 0; k < c.most_places(); ++k) {
        PlaceNow& now = s.nows[kMostPlaces * i + k];
        CurvePlace& place = c.places[k];
        const bool wanted = !of.moved && place.used && !c.over;
        if (wanted) now = follow(c, place, s.motions);
        const bool found = now.status == nurbs::ContactStatus::found;
        if (found) place = now.place;
        if (found && c.lifts && now.gap < 0) place.presses = true;
        const bool holds = found && (!c.lifts || place.presses);
        append_place_rows(c, holds ? &now : nullptr, rows);
      }
    }
}

void take_curve_impulses(Planar& all, Real h) {
  StepScratch& s = all.scratch;
  std::size_t row = s.first_curve_row;
  const auto act = [&](std::size_t r, Real& force) {
    const Row& of = s.rows[r];
    force += s.lambda[r] / (h * h);
    for (int i = 0; i < of.count; ++i)
      s.motions.velocity[of.body[i]] +=
          s.motions.inverse_mass[of.body[i]] * (s.lambda[r] / h * of.j[i]);
  };
  for (const Mechanism& of : all.mechanisms)
    for (const std::uint32_t i : of.curves) {
      FlatCurve& c = all.curves[i];
      for (std::size_t k = 0; k < c.most_places(); ++k, row += c.rows_per_place()) {
        CurvePlace& place = c.places[k];
        if (of.moved || !place.used || c.over) continue;
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
