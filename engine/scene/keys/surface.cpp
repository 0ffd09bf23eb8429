// Keys of NURBS surfaces, their faces and curves.
#include <array>

#include "engine/nurbs/knots.hpp"
#include "engine/scene/keys/keys.hpp"
#include "engine/scene/read/surface_words.hpp"

namespace pantin::detail::keys {
namespace {

using namespace rows;

constexpr Range kKnots{-1e9, 1e9, "a number between -1e9 and 1e9"};
constexpr Range kJoin{0, 1, "a length from 0 to 1 m"};
constexpr Range kDegree{1, nurbs::kMostDegree, "a whole number from 1 to 25"};
constexpr Range kCount{2, 1e6, "a whole number from 2 to 1000000"};
constexpr Range kFullTurn{1e-6, 360, "an angle above 0, at most 360 degrees"};

constexpr Key kScale =
    row("scale", ValueType::vector_or_number, "",
        "Scale factor along each axis or along all, applied before rotation and translation.")
        .within(kPositive)
        .or_else(1);
constexpr Key kInsideOut =
    flag("inside_out", "Whether the outer side is flipped to the inside, as of a bowl.")
        .or_else(false);
constexpr Key kPoints = row("points", ValueType::points, "m", "Control points.");
constexpr Key kWeights = row("weights", ValueType::number_list, "",
                             "Of the control points, above 0. Default: 1 for all.")
                             .within(kAnyNumber);
constexpr Key kHomogeneous = row("homogeneous", ValueType::number_list, "",
                                 "In place of points and weights: x w, y w, z w and w of each in "
                                 "sequence; exact where weights are not 1.")
                                 .within(kAnyNumber);
constexpr Exclusive kPointPairs[] = {{"homogeneous", "points weights"}};
constexpr AnyOf kPointNeeds[] = {
    {"points homogeneous", "found no \"points\", expected the control points"}};

constexpr Key type_key(std::span<const std::string_view> name, std::string_view about) {
  Key key = word("type", name, about);
  key.is_needed = true;
  return key;
}
constexpr Key face_type(std::size_t i) {
  return type_key(std::span(kFaceTypes).subspan(i, 1), "The kind of face.");
}
constexpr Key curve_type(std::size_t i) {
  return type_key(std::span(kCurveTypes).subspan(i, 1), "The kind of curve.");
}
constexpr Key radius(std::string_view about) {
  return number("radius", "m", kSize, about).needed(kSize.words);
}
constexpr Key curve(std::string_view name, std::string_view about) {
  return object(name, "curve", about).needed("a curve");
}

constexpr Key kCurveName = own_name("Name for joints. Needed in a list of curves.");

constexpr Key kTrims = objects(
    "trims", "curve",
    "Closed curves in the plane of the parameters: x is u, y is v, z is 0. The face is what "
    "an odd number of them surrounds: an outline, then holes. Default: the whole face.");

/// The keys of a face or a curve: its type, its own keys, and its position.
constexpr auto face_keys(std::size_t type, const auto&... own) {
  return std::array{face_type(type), own...,    kTrims,       kScale,
                    kPosition,       kRotation, kRotationDeg, kInsideOut};
}
constexpr auto curve_keys(std::size_t type, const auto&... own) {
  return std::array{curve_type(type), kCurveName, own...,      kScale,
                    kPosition,        kRotation,  kRotationDeg};
}

// ---- Surfaces ----------------------------------------------------------------------------------

constexpr Key kSurface[] = {
    text("$schema", "Of a file: where editors find this schema; not read."),
    own_name("Name for shapes. Needed in a list of surfaces."),
    objects("faces", "face", "The faces of the surface, outer sides outwards."),
    reference("file", "the path of a file of a surface",
              "A separate file of the surface, JSON of this kind. The path is relative to this "
              "file's folder."),
    number("tolerance", "m", kJoin, "Edges of faces that coincide within this distance are joined.")
        .or_else(1e-7),
    kScale,
    kPosition,
    kRotation,
    kRotationDeg,
    kInsideOut,
};
constexpr Exclusive kSurfacePairs[] = {{"faces", "file"}};
constexpr AnyOf kSurfaceNeeds[] = {
    {"faces file", "found no \"faces\", expected faces, or a \"file\""}};

constexpr auto kNurbsFace =
    face_keys(0,
              row("degrees", ValueType::wholes, "", "Along u and v.")
                  .holding(2)
                  .within(kDegree)
                  .needed("the degrees along u and v"),
              row("knots_u", ValueType::number_list, "",
                  "Non-decreasing; their number is points along u + degree + 1.")
                  .within(kKnots)
                  .needed("the knots along u"),
              row("knots_v", ValueType::number_list, "", "Likewise along v.")
                  .within(kKnots)
                  .needed("the knots along v"),
              row("points", ValueType::points, "m",
                  "Control points, u outermost: the first row along v, then the next."),
              kWeights, kHomogeneous,
              flag("periodic_u", "Whether the face is closed along u.").or_else(false),
              flag("periodic_v", "Whether the face is closed along v.").or_else(false));
constexpr auto kPlaneFace = face_keys(
    1, row("size", ValueType::numbers, "m", "Along x and along y, the origin in the middle.")
           .holding(2)
           .within(kSize)
           .needed("two lengths"));
constexpr auto kCylinderFace =
    face_keys(2, radius("About z."),
              number("height", "m", kSize, "From the origin along z.").needed(kSize.words));
constexpr auto kConeFace = face_keys(
    3,
    row("radii", ValueType::numbers, "m", "About z, at the bottom and at the top; 0: an apex.")
        .holding(2)
        .within(kNotNegative)
        .needed("two radii"),
    number("height", "m", kSize, "From the origin along z.").needed(kSize.words));
constexpr auto kSphereFace = face_keys(4, radius("About the origin."));
constexpr auto kEllipsoidFace =
    face_keys(5, vector("radii", "m", "Along x, y and z.").within(kSize).needed("three radii"));
constexpr auto kTorusFace =
    face_keys(6, radius("Of the tube's middle, about z."),
              number("tube", "m", kSize, "Radius of the tube.").needed(kSize.words));
constexpr auto kRevolutionFace =
    face_keys(7, curve("profile", "Curve that is revolved about z."),
              number("angle_deg", "degrees", kFullTurn, "Angle of revolution.").or_else(360));
constexpr auto kExtrusionFace =
    face_keys(8, curve("profile", "Curve that is extruded."),
              vector("way", "m", "Displacement from one end to the other.").needed("a vector"));
constexpr auto kSweepFace = face_keys(
    9, curve("section", "Curve that is swept along the path; for a rotating section, in x and y."),
    curve("path", "Path of the section."),
    flag("turning", "Whether the section rotates with the path, with the least rotation.")
        .or_else(false),
    whole("stations", 2, 1000, "Of a rotating section: number of positions where it is exact.")
        .or_else(24));
constexpr auto kInterpolationFace = face_keys(
    10, row("points", ValueType::points, "m", "On the surface, row after row.").needed("points"),
    row("columns", ValueType::whole, "", "Number of points in a row, along v.")
        .within(kCount)
        .needed("how many points are in a row"),
    row("degrees", ValueType::wholes, "", "Along u and v.")
        .holding(2)
        .within(kDegree)
        .or_else(3, 3, 0));

// ---- Curves ------------------------------------------------------------------------------------

constexpr auto kNurbsCurve = curve_keys(
    0,
    row("degree", ValueType::whole, "", "Of the polynomials.").within(kDegree).needed("a degree"),
    row("knots", ValueType::number_list, "", "Non-decreasing; their number is points + degree + 1.")
        .within(kKnots)
        .needed("the knots"),
    kPoints, kWeights, kHomogeneous,
    flag("periodic", "Whether the curve is closed.").or_else(false));
constexpr auto kLineCurve = curve_keys(1, vector("from", "m", "Start point.").needed("a point"),
                                       vector("to", "m", "End point.").needed("a point"));
constexpr auto kArcCurve =
    curve_keys(2, radius("About z."),
               angles_deg("angles_deg", "Start and end angle, from x towards y; at most 360 apart.")
                   .needed("two angles"));
constexpr auto kCircleCurve = curve_keys(3, radius("About z."));
constexpr auto kEllipseCurve = curve_keys(4, row("radii", ValueType::numbers, "m", "Along x and y.")
                                                 .holding(2)
                                                 .within(kSize)
                                                 .needed("two radii"));
constexpr auto kInterpolationCurve = curve_keys(
    5, row("points", ValueType::points, "m", "On the curve, in order.").needed("points"),
    row("degree", ValueType::whole, "", "Of the polynomials.").within(kDegree).or_else(3),
    flag("closed", "Whether it closes smoothly at the first point.").or_else(false));
constexpr auto kOutlineCurve = curve_keys(
    6,
    row("points", ValueType::points, "m",
        "Corners in order, z = 0; the last side closes the polygon.")
        .needed("the corners"),
    number("rounding", "m", kNotNegative, "Radius of the arcs at its corners.").or_else(0));
constexpr auto kJoinedCurve =
    curve_keys(7, objects("curves", "curve", "Each begins or ends where the previous one ends.")
                      .needed("curves"));

// ---- Outlines of machine parts -----------------------------------------------------------------

constexpr Range kPressure{5, 40, "an angle from 5 to 40 degrees"};
constexpr Range kTurns{0.1, 1000, "a number from 0.1 to 1000"};

constexpr Key kModule =
    number("module", "m", kSize, "Pitch diameter by number of teeth.").needed(kSize.words);
constexpr Key kPressureAngle =
    number("pressure_angle_deg", "degrees", kPressure, "Of the flanks at the pitch line.")
        .or_else(20);
constexpr Key kBacklash = number("backlash", "m", kNotNegative,
                                 "Play of two such profiles, on the pitch line: the teeth of each "
                                 "are thinner by half of it.")
                              .or_else(0);
constexpr auto kGearCurve = curve_keys(
    8, whole("teeth", 5, 1000, "Number of teeth; one of them is along x.").needed("a number"),
    kModule, kPressureAngle, kBacklash);
constexpr auto kRackCurve =
    curve_keys(9,
               whole("teeth", 1, 1000, "Number of teeth along x; one of them is at the origin.")
                   .needed("a number"),
               kModule, kPressureAngle, kBacklash,
               number("back", "m", kSize, "Distance of its back from the pitch line, which is x.")
                   .needed(kSize.words));
constexpr auto kCamCurve = curve_keys(
    10, number("base", "m", kSize, "Least radius.").needed(kSize.words),
    number("roller", "m", kNotNegative,
           "Radius of the follower's roller. Default: a flat face across the lift."),
    word("law", kCamLaws, "How it rises and returns: with a steady acceleration at both ends.")
        .or_else(0),
    row("lifts", ValueType::pairs, "degrees, m",
        "Angles, seen from the cam, in order within a turn, and the lift of the follower there; "
        "it moves by the law from each to the next, and rests between equal ones.")
        .needed("pairs of an angle and a lift"));
constexpr auto geneva_keys(std::size_t type) {
  return curve_keys(
      type, whole("slots", 3, 64, "Number of slots.").needed("a number"),
      number("distance", "m", kSize, "Of both axes. The crank's arm is distance sin(180 / slots).")
          .needed(kSize.words),
      number("pin", "m", kSize, "Radius of the pin.").needed(kSize.words),
      number("lip", "m", kSize,
             "Radius of the ends of a slot's walls. Default: a third of the pin."),
      number("clearance", "m", kNotNegative, "Between the disc and the wheel.").or_else(2e-5));
}
constexpr auto kGenevaWheelCurve = geneva_keys(11), kGenevaDiscCurve = geneva_keys(12);
constexpr auto kHelixCurve =
    curve_keys(13, radius("About z; it begins on x."),
               number("pitch", "m", kSize, "Height of one turn.").needed(kSize.words),
               number("turns", "", kTurns, "Number of turns.").needed(kTurns.words));

}  // namespace

constinit const KeySet surface{"surface",
                               "A surface of NURBS faces. A closed one is a solid; an open one "
                               "collides on its outer side, to which u x v points.",
                               kSurface, kSurfacePairs, kSurfaceNeeds};
constinit const KeySet nurbs_face{"nurbs_face", "A face given by knots and control points.",
                                  kNurbsFace, kPointPairs, kPointNeeds};
constinit const KeySet plane_face{"plane_face", "A rectangle across z.", kPlaneFace};
constinit const KeySet cylinder_face{"cylinder_face", "The side of a cylinder.", kCylinderFace};
constinit const KeySet cone_face{"cone_face", "The side of a cone.", kConeFace};
constinit const KeySet sphere_face{
    "sphere_face",
    "A sphere. If it is the only face and not transformed, it has no poles: it is six charts.",
    kSphereFace};
constinit const KeySet ellipsoid_face{"ellipsoid_face", "An ellipsoid; poles as for a sphere.",
                                      kEllipsoidFace};
constinit const KeySet torus_face{"torus_face", "A torus.", kTorusFace};
constinit const KeySet revolution_face{
    "revolution_face", "A surface of revolution about z; u is the angle, v runs along the curve.",
    kRevolutionFace};
constinit const KeySet extrusion_face{
    "extrusion_face", "An extruded curve; u runs along the curve, v along the extrusion.",
    kExtrusionFace};
constinit const KeySet sweep_face{
    "sweep_face", "A curve swept along a curve; u runs along the path, v along the section.",
    kSweepFace};
constinit const KeySet interpolation_face{
    "interpolation_face", "The surface that interpolates a grid of points.", kInterpolationFace};
constinit const KeySet nurbs_curve{"nurbs_curve", "A curve given by knots and control points.",
                                   kNurbsCurve, kPointPairs, kPointNeeds};
constinit const KeySet line_curve{"line_curve", "A straight line.", kLineCurve};
constinit const KeySet arc_curve{"arc_curve", "An arc of a circle.", kArcCurve};
constinit const KeySet circle_curve{"circle_curve", "A full circle.", kCircleCurve};
constinit const KeySet ellipse_curve{"ellipse_curve", "A full ellipse.", kEllipseCurve};
constinit const KeySet interpolation_curve{
    "interpolation_curve", "The curve that interpolates points.", kInterpolationCurve};
constinit const KeySet outline_curve{
    "outline_curve", "A closed polygon with rounded corners: straight lines and arcs.",
    kOutlineCurve};
constinit const KeySet gear_curve{
    "gear_curve", "The outline of a gear with involute teeth, about the origin.", kGearCurve};
constinit const KeySet rack_curve{"rack_curve", "The outline of a rack with teeth along y.",
                                  kRackCurve};
constinit const KeySet cam_curve{
    "cam_curve", "The outline of a disc cam, for a follower that moves in line with its centre.",
    kCamCurve};
constinit const KeySet geneva_wheel_curve{
    "geneva_wheel_curve", "The wheel of a Geneva drive, about its axis, with a slot along x.",
    kGenevaWheelCurve};
constinit const KeySet geneva_disc_curve{
    "geneva_disc_curve",
    "The disc of a Geneva drive's crank, about its axis, with a recess along x, where the pin is.",
    kGenevaDiscCurve};
constinit const KeySet helix_curve{"helix_curve", "A helix about z.", kHelixCurve};
constinit const KeySet joined_curve{
    "joined_curve", "Curves in sequence; closed if the last ends where the first begins.",
    kJoinedCurve};

}  // namespace pantin::detail::keys
