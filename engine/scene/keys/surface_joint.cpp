// Keys of joints of surfaces in contact.
#include <string>

#include "engine/scene/read/read.hpp"
#include "engine/scene/read/surface_words.hpp"
#include "engine/world/surface_contact.hpp"
#include "engine/world/surface_start.hpp"

namespace pantin::detail {
namespace {

using namespace rows;
using Side = SurfaceSideRecipe;
using J = SurfaceJointRecipe;

constexpr Range kFriction{0, 1e3, "a number from 0 to 1000"};
constexpr Range kContacts{1, kMostSpots, "a whole number from 1 to 8"};

constexpr Key kSide[] = {
    needed_reference<&Side::body>("body", "the name of a body", "Name of a body, or \"world\"."),
    of_object("surface", ValueType::object_or_reference, "surface",
              "The name of one of the scene's surfaces, a surface, or the path of a surface file. "
              "Default: that of the body's first smooth shape: a sphere, an ellipsoid, the side of "
              "a cylinder, a plane, a NURBS shape."),
    of_object("curve", ValueType::object_or_reference, "curve",
              "In place of a surface: the name of one of the scene's curves, or a curve. The outer "
              "side is outside a closed curve, and right of an open one. Two curves lie in one "
              "plane; of a curve and a surface the curve is on \"a\"."),
    flag("inside_out", "Whether the outer side of the curve is flipped, as of a slot.").or_else(0),
    vector("position", "m",
           "Position of the frame of the surface or curve in the body's own. Default: its origin.")
        .or_else(0),
    kRotation,
    kRotationDeg,
};

constexpr Exclusive kSidePairs[] = {{"surface", "curve"}};

constexpr Key kSurfaceJoint[] = {
    own_name<&J::name>("Default \"a-b\"."),
    object<&J::a>("a", "surface_side", "The first body.").needed("a body and its surface"),
    object<&J::b>("b", "surface_side", "The second body; the common normal is that of its surface.")
        .needed("a body and its surface"),
    word<&J::motion>("motion", kSurfaceMotions,
                     "sliding: without friction. rolling: without slip, free to spin about the "
                     "common normal. rolling_without_spin: without slip or spin.")
        .or_else(0),
    flag<&J::lifts>(
        "unilateral",
        "Whether the contact may open and close. Default: the surfaces are held together.")
        .or_else(0),
    number<&J::friction>(
        "friction", "", kFriction,
        "Coefficient of Coulomb friction, for sliding or rolling, with transitions between both. "
        "Default: sliding has none, rolling never slips."),
    row<&J::contacts>("contacts", ValueType::whole, "",
                      "Of a unilateral joint: maximum number of simultaneous contact points, from "
                      "1 to 8. Default: 1 for an ellipsoid and another or a plane, else 4.")
        .within(kContacts),
    word<&J::on_rim>(
        "on_rim", kOnRims,
        "Action where the contact leaves a surface over its rim, meets a point without a normal, "
        "or the surfaces conform: stop the run, or release the joint for good.")
        .or_else(0),
};

}  // namespace

constinit const KeySet keys::surface_side{"surface_side",
                                          "A body and its surface. A surface given here may be "
                                          "placed; that of a shape is where the shape is.",
                                          kSide, kSidePairs};
constinit const KeySet keys::surface_joint{
    "surface_joint",
    "Two bodies whose surfaces, or curves, touch in a point and slide or roll. They start where "
    "their gap is smallest, which the solver closes. For the solver lagrangian; two curves in the "
    "xy plane for planar, too.",
    kSurfaceJoint};

bool read_members(const Reading& reading, const Reader& from, SurfaceSideRecipe& side) {
  if (!from.is_object()) return false;
  const bool is_whole = read_rows(reading, from, side);
  if (from.has("surface")) {
    side.surface = read_skin(reading, from);
    if (!side.surface) return false;
    side.pose = from.pose();
  } else if (from.has("curve")) {
    const auto curve = read_own_curve(reading, from);
    if (!curve) return false;
    side.curve =
        contact_curve(*curve, from.flag("inside_out") ? OuterSide::left : OuterSide::right);
    if (const JsonNode& name = reading.json[from.find("curve")]; name.kind == JsonKind::string)
      side.curve_name = name.text;
    side.pose = from.pose();
    if (const std::string why = curve_fault(*side.curve); !why.empty()) {
      from.error("curve", why);
      return false;
    }
  } else {
    for (const std::string_view key : {"position", "rotation", "rotation_deg"})
      if (from.has(key))
        from.error(
            key,
            "found \"" + std::string(key) +
                "\" without a \"surface\", expected one: that of a shape is where the shape is");
  }
  if (from.has("inside_out") && !from.has("curve"))
    from.error("inside_out",
               "found \"inside_out\" without a \"curve\", expected one: that of a surface stands "
               "in the surface");
  return is_whole;
}

bool read_members(const Reading& reading, const Reader& from, SurfaceJointRecipe& r) {
  const bool is_whole = read_rows(reading, from, r);
  if (r.friction && r.motion == SurfaceMotion::rolling_without_spin)
    from.error("friction",
               "found a friction of \"rolling_without_spin\", expected the motion \"sliding\" or "
               "\"rolling\": its spin torque is unlimited");
  if (r.contacts.value_or(1) > 1 && !r.lifts)
    from.error(
        "contacts",
        "found several contacts of a bilateral joint, expected one, or \"unilateral\": true");
  return is_whole;
}

}  // namespace pantin::detail
