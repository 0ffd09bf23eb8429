// Belts.
#include "engine/scene/read.hpp"

namespace pantin::detail {
namespace {

constexpr int kEllipseCorners = 720;

std::vector<Vec3> ellipse(const Real (&half_axes)[2]) {
  std::vector<Vec3> points;
  for (int i = 0; i < kEllipseCorners; ++i) {
    const Real at = 2 * kPi * i / kEllipseCorners;
    points.push_back({half_axes[0] * std::cos(at), half_axes[1] * std::sin(at), 0});
  }
  return points;
}

std::vector<Vec3> read_corners(const Reader& from) {
  std::vector<Vec3> points;
  for (const NodeId node : from.items("outline")) {
    Real at[2] = {};
    if (!from.numbers_at(node, at, kAnyNumber)) return {};
    points.push_back({at[0], at[1], 0});
  }
  if (hull_outline(points).corners.empty())
    from.diagnostics.error_value(from.find("outline"),
                                 "three corners or more that do not lie on one line");
  return points;
}

std::optional<PulleyRecipe> read_pulley(const Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "belt_pulley");
  if (!from.is_object()) return std::nullopt;
  PulleyRecipe pulley;
  const auto body = from.reference("body");
  pulley.at = read_point(from, "point", "anchor");
  pulley.radius = from.number("radius", 0);
  pulley.is_outside = from.word("side") == 1;
  Real half_axes[2] = {};
  if (from.has("half_axes") && from.numbers("half_axes", half_axes))
    pulley.outline = ellipse(half_axes);
  if (from.has("outline")) pulley.outline = read_corners(from);
  if (!body) return std::nullopt;
  pulley.body = *body;
  return pulley;
}

}  // namespace

std::optional<BeltRecipe> read_belt(const Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "belt");
  if (!from.is_object()) return std::nullopt;
  BeltRecipe belt;
  belt.name = optional_name(from);
  bool whole = true;
  for (const NodeId pulley : from.items("pulleys"))
    if (auto read = read_pulley(reading, pulley))
      belt.pulleys.push_back(std::move(*read));
    else
      whole = false;
  belt.crossed = from.flag("crossed");
  belt.pretension = from.number("pretension"), belt.friction = from.number("friction");
  belt.width = from.number("width");
  belt.has_links = from.word("level") == 1, belt.links = from.whole("links", 0);
  belt.mass = from.number("mass");
  if (belt.has_links && !from.has("friction")) belt.friction = 0.6;
  belt.material = read_material(reading, from, 0);
  const std::size_t count = belt.pulleys.size();
  if (from.has("pulleys") && whole && (count < 2 || count > kMostPulleys))
    from.diagnostics.error(from.find("pulleys"), "found " + std::to_string(count) +
                                                     " pulleys, expected 2 to " +
                                                     std::to_string(kMostPulleys));
  if (belt.friction > 0 && count > 2 && !belt.has_links)
    from.diagnostics.error(from.find("friction"),
                           "found \"friction\" of a belt over " + std::to_string(count) +
                               " pulleys, expected 2: of more it cannot be said which one slips");
  if (!whole || count < 2 || count > kMostPulleys) return std::nullopt;
  return belt;
}

}  // namespace pantin::detail
