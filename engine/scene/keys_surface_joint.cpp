// Keys of bodies whose surfaces touch.
#include "engine/scene/keys.hpp"
#include "engine/scene/surface_words.hpp"
#include "engine/world/surface_contact.hpp"

namespace pantin::detail::keys {
namespace {

using namespace rows;

constexpr Range kFriction{0, 1e3, "a number from 0 to 1000"};
constexpr Range kContacts{1, kMostSpots, "a whole number from 1 to 8"};

constexpr Key kSide[] = {
    reference("body", "the name of a body", "Name of a body, or \"world\".")
        .needed("the name of a body"),
    of_object("surface", ValueType::object_or_reference, "surface",
              "The name of one of the scene's surfaces, a surface, or the path of a file of one. "
              "Default: that of the body's first shape that is smooth: a sphere, an ellipsoid, the "
              "side of a cylinder, a plane, a NURBS shape."),
    of_object("curve", ValueType::object_or_reference, "curve",
              "In place of a surface: the name of one of the scene's curves, or a curve. Outside "
              "is outside a closed one, and right of the way of an open one. Two curves touch in "
              "one plane; one that meets a surface is that of \"a\"."),
    flag("inside_out", "Whether the outer side of the curve is its other one, as of a slot.")
        .or_else(0),
    vector("position", "m",
           "Where the frame of the surface or curve is in the body's own. Default: its origin.")
        .or_else(0),
    kRotation,
    kRotationDeg,
};

constexpr Exclusive kSidePairs[] = {{"surface", "curve"}};

constexpr Key kSurfaceJoint[] = {
    own_name("Default \"a-b\"."),
    object("a", "surface_side", "One of the two.").needed("a body and its surface"),
    object("b", "surface_side", "The other; the common normal is that of its surface.")
        .needed("a body and its surface"),
    word("motion", kSurfaceMotions,
         "sliding: without friction. rolling: without slip, free to spin about the common normal. "
         "rolling_without_spin: neither.")
        .or_else(0),
    flag("unilateral",
         "Whether they may come apart, and touch again. Default: they are held together.")
        .or_else(0),
    number(
        "friction", "", kFriction,
        "Coulomb's coefficient, of sliding or rolling: what slides until it rolls, and what rolls "
        "until it slips. Default: sliding has none, rolling holds."),
    row("contacts", ValueType::whole, "",
        "Of a unilateral joint: at how many places at once they may touch, from 1 to 8. Default: 1 "
        "for an ellipsoid and another or a plane, else 4.")
        .within(kContacts),
    word("on_rim", kOnRims,
         "What happens where the contact leaves a surface over its rim, meets a place without a "
         "normal, or the surfaces fit one another: stop the run, or release the joint for good.")
        .or_else(0),
};

}  // namespace

constinit const KeySet surface_side{"surface_side",
                                    "A body and its surface. With a surface of its own it may be "
                                    "moved; that of a shape is where the shape is.",
                                    kSide, kSidePairs};
constinit const KeySet surface_joint{
    "surface_joint",
    "Two bodies whose surfaces, or curves, touch in a point, slide or roll. They start where their "
    "gap is smallest, which the solver closes. For the solver lagrangian; two curves of the plane "
    "of x and y for planar, too.",
    kSurfaceJoint};

}  // namespace pantin::detail::keys
