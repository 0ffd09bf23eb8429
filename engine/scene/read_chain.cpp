#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "engine/scene/read.hpp"

namespace pantin::detail {
namespace {

int most_links(const Reading& reading) {
  constexpr auto kMost = static_cast<std::size_t>(std::numeric_limits<int>::max());
  return std::max(1, static_cast<int>(std::min(reading.limits.bodies, kMost)));
}

/// A chain from point to point; no links if they do not make one.
void read_path(const Reading& reading, const Reader& from, ChainRecipe& chain) {
  const std::size_t refused_before = reading.diagnostics.error_count();
  const std::vector<NodeId> nodes = from.items("path");
  for (NodeId node : nodes) {
    Vec3 p(0);
    if (!from.numbers_at(node, {&p.x, 3}, kAnyNumber)) continue;
    if (!chain.path.empty() && glm::length(p - chain.path.back()) < kSize.least)
      reading.diagnostics.error(node, "found the point before again, expected another");
    chain.path.push_back(p);
  }
  const std::size_t least = chain.closed ? 3 : 2;
  if (nodes.size() < least)
    reading.diagnostics.error_value(
        from.find("path"),
        chain.closed ? "three points or more of a closed chain" : "two points or more");
  else if (reading.diagnostics.error_count() == refused_before && chain.closed &&
           glm::length(chain.path.back() - chain.path.front()) < kSize.least)
    reading.diagnostics.error(nodes.back(),
                              "found the first point again, expected another: a "
                              "closed chain returns by itself");
  if (reading.diagnostics.error_count() != refused_before) return;
  chain.links = static_cast<int>(chain.path.size()) - (chain.closed ? 0 : 1);
}

/// Whether the requested layout is possible; reports an error if not.
bool can_lie(const Reading& reading, const Reader& from, const ChainRecipe& chain, int links) {
  if (chain.closed && links < 3) {
    reading.diagnostics.error_value(from.find("links"), "3 links or more of a closed chain");
    return false;
  }
  if (!chain.end) return true;
  const Real reach = links * chain.length, span = glm::length(*chain.end - chain.start);
  if (span <= reach * (1 + 1e-9) && (links > 1 || span >= reach * (1 - 1e-9))) return true;
  reading.diagnostics.error(from.find("end"), "found an end " + written(span) +
                                                  " m from the start, expected one that " +
                                                  written(reach) + " m of links can meet");
  return true;  // as long as it is, so that names in it are known
}

/// Number of links of a chain and its layout; no links if the layout is impossible.
void read_course(const Reading& reading, const Reader& from, ChainRecipe& chain) {
  chain.closed = from.flag("closed");
  if (from.has("axis")) chain.axis = from.direction("axis", Vec3(0, 0, 1));
  if (from.has("path")) return read_path(reading, from, chain);
  if (chain.closed && from.has("end"))
    from.diagnostics.error_at_key(from.find("end"),
                                  "found \"end\" beside \"closed\", expected only one of them");
  const int links = from.whole("links", 0, most_links(reading));
  chain.length = from.number("length", 0);
  chain.start = from.vec("start");
  chain.direction = from.direction("direction", chain.direction);
  chain.end = from.vec_if("end");
  chain.sag = from.direction("sag", chain.sag);
  if (links == 0 || chain.length == 0) return;
  if (can_lie(reading, from, chain, links)) chain.links = links;
}

void read_attachments(const Reader& from, ChainRecipe& chain) {
  chain.attach = from.reference("attach");
  chain.end_attach = from.reference("end_attach");
  if (chain.closed && from.has("end_attach"))
    from.diagnostics.error_at_key(
        from.find("end_attach"),
        "found \"end_attach\" of a closed chain, expected none: its end is "
        "its start");
}

}  // namespace

ChainRecipe read_chain(const Reading& reading, NodeId node) {
  const Reader from = open_of_class(reading, node, "chain");
  ChainRecipe chain;
  if (!from.is_object()) return chain;
  chain.name = from.name();
  read_course(reading, from, chain);
  for (NodeId material : from.items("materials"))
    chain.materials.push_back(find_material(reading, material, 0));
  BodyRecipe& link = chain.link;
  link.mass_properties = read_mass_properties(reading, from, Motion::dynamic);
  link.velocity = from.vec("velocity");
  link.angular_velocity = from.vec("angular_velocity");
  link.drag = from.number("drag");
  link.gravity_scale = from.number("gravity_scale");
  link.solver = read_solver(reading, from, reading.solver);
  read_collision_of(reading, from, link);
  chain.mass_ratio = from.number("mass_ratio");
  chain.tip_mass_factor = from.number("tip_mass_factor");
  read_attachments(from, chain);
  chain.turn = read_turn(reading, from);
  return chain;
}

BodyRecipe read_stairs(const Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "stairs");
  BodyRecipe stairs;
  if (!from.is_object()) return stairs;
  stairs.motion = Motion::fixed;
  const std::string name = from.name();
  bool is_whole = true;
  for (std::string_view key : {"count", "width", "rise", "run"})
    is_whole = from.has(key) && is_whole;
  const int count = from.whole("count", 1);
  const Real width = from.number("width", 1), rise = from.number("rise", 1),
             run = from.number("run", 1);
  stairs.pose = from.pose();
  const std::uint32_t material = read_material(reading, from, 0);
  // Each step reaches down to the floor, so that none can be slipped under.
  for (int i = 0; i < count; ++i) {
    Shape step{ShapeKind::box, 0.5 * Vec3(run, (i + 1) * rise, width), {}};
    step.local.position = {(i + 0.5) * run, step.size.y, 0};
    step.material = material;
    stairs.mass_properties.shapes.push_back(step);
  }
  const std::optional<Collision> solid = reading.collision.value_or(Collision{});
  stairs.collision = read_collision(reading, from, solid);
  if (is_whole) stairs.name = name;
  return stairs;
}

}  // namespace pantin::detail
