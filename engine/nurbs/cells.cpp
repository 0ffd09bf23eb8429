#include "engine/nurbs/cells.hpp"

#include <algorithm>
#include <cmath>

namespace pantin::detail::nurbs {
namespace {

constexpr Real kSlack = 1e-12;  // relative: allowance for rounding

Vec3 unit_or_none(Vec3 v) {
  const Real length = glm::length(v);
  return length > 0 ? v / length : Vec3(0);
}

/// Largest change of the first derivatives within a cell, each times half the cell's width.
struct Changes {
  Real u, v;
};
Changes changes_of(const PatchCell& c) {
  const Leaf& leaf = *c.leaf;
  const Real mixed = leaf.second[1] * c.share_u * c.share_v;
  return {leaf.second[0] * c.share_u * c.share_u + mixed,
          leaf.second[2] * c.share_v * c.share_v + mixed};
}

void set_sides(PatchCell& c) {
  c.sides[0] = unit_or_none(glm::cross(c.normal, c.along_u));
  c.sides[1] = unit_or_none(glm::cross(c.normal, c.along_v));
}

// Sharpens the bounds by the derivatives at the middle; `whole` is the normal of its leaf.
void bound(PatchCell& c, Vec3 whole) {
  const Changes by = changes_of(c);
  c.sag = (by.u + by.v) / 2 + kSlack * c.leaf->radius;
  c.normal = Vec3(0), c.turn = kPi;
  const Vec3 across = glm::cross(c.along_u, c.along_v);
  const Real area = glm::length(across);
  if (!(area > 0)) return;
  c.normal = across / area;
  set_sides(c);
  const Real change = glm::length(c.along_u) * by.v + by.u * glm::length(c.along_v) + by.u * by.v;
  c.turn = change < area ? std::asin(change / area) + kSlack : kPi;
  if (c.leaf->turn > kPi / 2) return;
  const Real cosine = glm::dot(c.normal, whole);
  c.turn = std::min(c.turn, c.leaf->turn + std::acos(std::min(cosine, 1.0)) + 1e-7);
}

bool may_be_opposite(Vec3 a, Vec3 b, Real turn) {
  return turn >= kPi || -glm::dot(a, b) >= std::cos(turn) - 1e-9;
}

}  // namespace

PatchCell cell_of(const Face& face, const Leaf& leaf, const Standing& at) {
  PatchCell c{.face = &face, .leaf = &leaf, .u = leaf.u, .v = leaf.v};
  c.centre = at.turn * leaf.centre + at.origin;
  c.along_u = at.turn * leaf.along_u, c.along_v = at.turn * leaf.along_v;
  c.normal = at.turn * leaf.normal, c.turn = leaf.turn;
  const Changes by = changes_of(c);
  c.sag = (by.u + by.v) / 2 + kSlack * leaf.radius;
  set_sides(c);
  return c;
}

PatchCell half_of(const PatchCell& cell, int which, const Standing& at) {
  PatchCell c = cell;
  const Changes by = changes_of(cell);
  Real by_u = by.u, by_v = by.v;
  if (cell.turn > kStraight) by_u *= glm::length(cell.along_v), by_v *= glm::length(cell.along_u);
  const bool cuts_u = by_u != by_v ? by_u > by_v : cell.share_u >= cell.share_v;
  Range& range = cuts_u ? c.u : c.v;
  (cuts_u ? c.share_u : c.share_v) /= 2;
  (which == 0 ? range.high : range.low) = range.middle();
  const Face::Piece piece = c.face->piece_at(c.leaf->u.middle(), c.leaf->v.middle());
  const Jet jet = c.face->at(piece, c.u.middle(), c.v.middle());
  c.centre = at.turn * jet.s + at.origin;
  c.along_u = at.turn * jet.u * (c.u.width() / 2), c.along_v = at.turn * jet.v * (c.v.width() / 2);
  bound(c, at.turn * c.leaf->normal);
  return c;
}

bool may_face(const PatchCell& a, const PatchCell& b, Real reach) {
  if (!may_be_opposite(a.normal, b.normal, a.turn + b.turn)) return false;
  const Vec3 d = a.centre - b.centre;
  const Real room = reach + kSlack * (glm::length(d) + a.leaf->radius + b.leaf->radius);
  const auto is_apart = [&](Vec3 axis, Real within) {
    return std::abs(glm::dot(d, axis)) > a.extent(axis) + b.extent(axis) + within;
  };
  for (const PatchCell* cell : {&a, &b}) {
    if (cell->normal == Vec3(0)) continue;
    if (is_apart(cell->normal, room)) return false;
    // The line between the points is along a normal of the cell.
    const Real beside = cell->turn < kPi / 2 ? room * std::sin(cell->turn) + (room - reach) : room;
    for (const Vec3& side : cell->sides)
      if (is_apart(side, beside)) return false;
  }
  return true;
}

Real least_distance(const PatchCell& a, const PatchCell& b, Vec3 toward) {
  const Vec3 d = a.centre - b.centre;
  Real least = 0;
  const auto try_axis = [&](Vec3 axis) {
    least = std::max(least, std::abs(glm::dot(d, axis)) - a.extent(axis) - b.extent(axis));
  };
  try_axis(unit_or_none(d)), try_axis(toward);
  for (const PatchCell* cell : {&a, &b}) {
    try_axis(cell->normal);
    for (const Vec3& side : cell->sides) try_axis(side);
  }
  return least * (1 - kSlack);
}

void approach(Vec3 d, std::span<const Vec3> ways, std::span<Real> shares) {
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round)
    for (std::size_t i = 0; i < ways.size(); ++i) {
      const Real square = glm::dot(ways[i], ways[i]);
      if (!(square > 0)) continue;
      const Real to = std::clamp(shares[i] - glm::dot(d, ways[i]) / square, -1.0, 1.0);
      d += (to - shares[i]) * ways[i];
      shares[i] = to;
    }
}

bool may_face(const Region& a, const Region& b, const Standing& a_in_b, Real reach) {
  const Real turn = a.turn + b.turn;
  if (turn < kPi && !may_be_opposite(a_in_b.turn * a.normal, b.normal, turn)) return false;
  return least_distance(a, b, a_in_b) <= reach;
}

// Separating axes: those of both boxes.
Real least_distance(const Region& a, const Region& b, const Standing& a_in_b) {
  const Vec3 half_a = (a.high - a.low) / 2.0, half_b = (b.high - b.low) / 2.0;
  const Vec3 d = a_in_b.turn * ((a.low + a.high) / 2.0) + a_in_b.origin - (b.low + b.high) / 2.0;
  Real least = 0;
  for (int k = 0; k < 3; ++k) {
    Real along_b = half_b[k], along_a = half_a[k];
    for (int j = 0; j < 3; ++j) {
      along_b += std::abs(a_in_b.turn[j][k]) * half_a[j];
      along_a += std::abs(a_in_b.turn[k][j]) * half_b[j];
    }
    least = std::max(
        {least, std::abs(d[k]) - along_b, std::abs(glm::dot(a_in_b.turn[k], d)) - along_a});
  }
  return least * (1 - kSlack) - kSlack * glm::length(d);
}

}  // namespace pantin::detail::nurbs
