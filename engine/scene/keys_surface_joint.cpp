// Keys of bodies whose surfaces touch.
#include "engine/scene/keys.hpp"
#include "engine/scene/surface_words.hpp"

namespace pantin::detail::keys {
namespace {

using namespace rows;

constexpr Key kSide[] = {
    reference("body", "the name of a body", "Name of a body, or \"world\".")
        .needed("the name of a body"),
    of_object("surface", ValueType::object_or_reference, "surface",
              "The name of one of the scene's surfaces, a surface, or the path of a file of one. "
              "Default: that of the body's first shape that is smooth: a sphere, an ellipsoid, the "
              "side of a cylinder, a plane, a NURBS shape."),
    vector("position", "m", "Where the surface's frame is in the body's own. Default: its origin.")
        .or_else(0),
    kRotation,
    kRotationDeg,
};

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
    word("on_rim", kOnRims,
         "What happens where the contact leaves a surface over its rim, meets a place without a "
         "normal, or the surfaces fit one another: stop the run, or release the joint for good.")
        .or_else(0),
};

}  // namespace

constinit const KeySet surface_side{"surface_side",
                                    "A body and its surface. With a surface of its own it may be "
                                    "moved; that of a shape is where the shape is.",
                                    kSide};
constinit const KeySet surface_joint{
    "surface_joint",
    "Two bodies whose surfaces touch in a point, slide or roll. They start where their gap is "
    "smallest, which the solver closes. For the solver lagrangian.",
    kSurfaceJoint};

}  // namespace pantin::detail::keys
