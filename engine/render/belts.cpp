#include "engine/render/belts.hpp"

#include <algorithm>
#include <cmath>

namespace pantin::detail {
namespace {

constexpr Real kTurn = kPi / 24;                   // rad, between segments on a pulley
constexpr Real kMarkLength = 0.5, kMarkEvery = 8;  // relative to the width
constexpr Real kMostMarks = 200;

/// A closed route, and the arc lengths at its points.
struct Loop {
  std::vector<Vec3> points;
  std::vector<Real> lengths;

  void add(Vec3 p) {
    const Real on = points.empty() ? 0 : lengths.back() + glm::length(p - points.back());
    points.push_back(p), lengths.push_back(on);
  }
  Vec3 at(Real length) const {
    const auto next = std::upper_bound(lengths.begin() + 1, lengths.end() - 1, length);
    const auto i = static_cast<std::size_t>(next - lengths.begin());
    const Real part = (length - lengths[i - 1]) / std::max(lengths[i] - lengths[i - 1], 1e-12);
    return glm::mix(points[i - 1], points[i], std::clamp(part, 0.0, 1.0));
  }
};

BeltPiece piece_of(Vec3 from, Vec3 to, Vec3 half) {
  BeltPiece piece;
  piece.box.kind = ShapeKind::box, piece.box.size = half;
  const Vec3 way = to - from;
  const Real angle = 0.5 * std::atan2(way.y, way.x);
  piece.pose = {0.5 * (from + to), Quat(std::cos(angle), 0, 0, std::sin(angle))};
  return piece;
}

}  // namespace

void add_belt(const PosedWorld& scene, const Belt& belt, std::vector<BeltPiece>& to) {
  std::vector<Pose> poses;
  std::vector<Real> angles;
  for (const BeltPulley& p : belt.pulleys) {
    const std::uint32_t slot = scene.world.bodies.slot(p.body);
    if (slot == kNoSlot || !is_finite(scene.pose_of(slot))) return;
    poses.push_back(scene.pose_of(slot));
    angles.push_back(place_of(p, poses.back()).angle);
  }
  Belt now = belt;
  follow_belt(now, poses, angles);
  std::vector<Vec3> way;
  trace_belt(now, poses, kTurn, way);
  way.push_back(way.front());
  Loop loop;
  const Real z = to_world(poses.front(), belt.pulleys.front().anchor).z;
  for (Vec3 p : way) loop.add({p.x, p.y, z});
  const Vec3 half(0, 0.5 * kBeltThickness * belt.width, 0.5 * belt.width);
  for (std::size_t i = 0; i + 1 < loop.points.size(); ++i) {
    const Real length = loop.lengths[i + 1] - loop.lengths[i];
    if (length > 0)
      to.push_back(piece_of(loop.points[i], loop.points[i + 1],
                            half + Vec3(0.5 * length + 0.2 * half.y, 0, 0)));
  }
  const Real length = loop.lengths.back();
  if (!(length > 0)) return;
  const Real marks = std::clamp(std::round(length / (kMarkEvery * belt.width)), 3.0, kMostMarks);
  const Real first = now.travel - length / marks * std::floor(now.travel * marks / length);
  const Real along = 0.5 * kMarkLength * belt.width;
  for (Real i = 0; i < marks; ++i) {
    const Real at = first + i * length / marks;
    to.push_back(piece_of(loop.at(std::max(at - along, 0.0)), loop.at(std::min(at + along, length)),
                          {along, 1.15 * half.y, 1.02 * half.z}));
    to.back().is_mark = true;
  }
}

}  // namespace pantin::detail
