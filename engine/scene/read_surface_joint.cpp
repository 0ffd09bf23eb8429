// Bodies whose surfaces touch.
#include "engine/scene/read.hpp"
#include "engine/world/surface_start.hpp"

namespace pantin::detail {
namespace {

bool read_side(const Reading& reading, NodeId node, SurfaceSideRecipe& side) {
  const Reader from = reading.open(node, "surface_side");
  if (!from.is_object()) return false;
  const auto body = from.reference("body");
  if (from.has("surface")) {
    side.surface = read_skin(reading, from);
    if (!side.surface) return false;
    side.pose = from.pose();
  } else if (from.has("curve")) {
    const auto curve = read_own_curve(reading, from);
    if (!curve) return false;
    side.curve =
        contact_curve(*curve, from.flag("inside_out") ? OuterSide::left : OuterSide::right);
    side.pose = from.pose();
    if (const std::string why = curve_fault(*side.curve); !why.empty()) {
      reading.diagnostics.error(from.find("curve"), why);
      return false;
    }
  } else {
    for (const std::string_view key : {"position", "rotation", "rotation_deg"})
      if (from.has(key))
        reading.diagnostics.error(from.find(key), "found \"" + std::string(key) +
                                                      "\" without a \"surface\", expected one: "
                                                      "that of a shape is where the shape is");
  }
  if (from.has("inside_out") && !from.has("curve"))
    reading.diagnostics.error(from.find("inside_out"),
                              "found \"inside_out\" without a \"curve\", expected one: that of a "
                              "surface stands in the surface");
  if (!body) return false;
  side.body = *body;
  return true;
}

}  // namespace

std::optional<SurfaceJointRecipe> read_surface_joint(const Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "surface_joint");
  if (!from.is_object()) return std::nullopt;
  SurfaceJointRecipe r;
  r.name = optional_name(from);
  r.motion = static_cast<SurfaceMotion>(from.word("motion"));
  r.lifts = from.flag("unilateral");
  r.on_rim = static_cast<OnRim>(from.word("on_rim"));
  if (from.has("friction")) r.friction = from.number("friction");
  if (from.has("contacts")) r.contacts = static_cast<std::uint8_t>(from.whole("contacts"));
  if (r.friction && r.motion == SurfaceMotion::rolling_without_spin)
    reading.diagnostics.error(from.find("friction"),
                              "found a friction of \"rolling_without_spin\", expected the motion "
                              "\"sliding\" or \"rolling\": nothing bounds what holds the spin");
  if (r.contacts.value_or(1) > 1 && !r.lifts)
    reading.diagnostics.error(from.find("contacts"),
                              "found several contacts of a joint that is held together, expected "
                              "one, or \"unilateral\": true");
  bool whole = true;
  for (const auto& [key, side] : {std::pair{"a", &r.a}, {"b", &r.b}}) {
    const NodeId at = from.find(key);
    whole = at != kNoNode && read_side(reading, at, *side) && whole;
  }
  if (!whole) return std::nullopt;
  return r;
}

}  // namespace pantin::detail
