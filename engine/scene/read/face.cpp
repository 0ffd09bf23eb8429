// Faces of NURBS surfaces, and the curves that they are made of.
#include <algorithm>
#include <array>
#include <cmath>

#include "engine/nurbs/check.hpp"
#include "engine/nurbs/makers.hpp"
#include "engine/nurbs/plane_curves.hpp"
#include "engine/scene/read/named.hpp"
#include "engine/scene/read/profile.hpp"
#include "engine/scene/read/surface_words.hpp"

namespace pantin::detail {
namespace {

using MaybeFace = std::optional<nurbs::Surface>;
using MaybeCurve = std::optional<nurbs::Curve>;

/// What has been read so far, if no error has been reported since.
struct Whole {
  const Reader& from;
  std::size_t refused_before = from.diagnostics.error_count();

  bool is_good() const { return from.diagnostics.error_count() == refused_before && !has_faults(); }
  /// Whether some number is not finite, which was reported when the text was read.
  bool has_faults() const {
    const auto is_below = [&](const JsonFault& fault) {
      NodeId node = fault.node;
      while (node != kNoNode && node != from.node) node = from.json[node].parent;
      return node == from.node;
    };
    return std::ranges::any_of(from.json.faults, is_below);
  }
};

std::vector<Real> read_list(const Reader& from, std::string_view key) {
  std::vector<Real> values(from.items(key).size());
  if (!values.empty()) from.numbers(key, values);
  return values;
}

constexpr Real kMostDegree = 1000;

std::array<int, 2> read_degrees(const Reader& from, int otherwise) {
  Real degrees[2] = {Real(otherwise), Real(otherwise)};
  from.numbers("degrees", degrees);
  const auto fits = [](Real d) { return d >= 0 && d <= kMostDegree && d == std::floor(d); };
  if (!fits(degrees[0]) || !fits(degrees[1])) {
    from.error_value("degrees", "two whole numbers from 0 to 1000");
    return {otherwise, otherwise};
  }
  return {static_cast<int>(degrees[0]), static_cast<int>(degrees[1])};
}

/// Control points with their weights, or in homogeneous form as stored.
std::vector<nurbs::Weighted> read_net(const Reader& from) {
  std::vector<nurbs::Weighted> net;
  if (from.has("homogeneous")) {
    const std::vector<Real> all = read_list(from, "homogeneous");
    if (all.size() % 4 != 0)
      from.error("homogeneous",
                 "found " + std::to_string(all.size()) + " numbers, expected four a point");
    for (std::size_t i = 0; i + 3 < all.size(); i += 4)
      net.emplace_back(all[i], all[i + 1], all[i + 2], all[i + 3]);
    return net;
  }
  const std::vector<Vec3> points = from.points();
  const std::vector<Real> weights = read_list(from, "weights");
  if (from.has("weights") && weights.size() != points.size())
    from.error("weights", "found " + std::to_string(weights.size()) + " weights, expected " +
                              std::to_string(points.size()) + ", one for each point");
  for (std::size_t i = 0; i < points.size(); ++i)
    net.emplace_back(points[i], i < weights.size() ? weights[i] : 1);
  return net;
}

// ---- Curves ------------------------------------------------------------------------------------

/// Reports invalid numbers, at the position of the curve.
bool is_whole(const Reader& from, const nurbs::Curve& curve) {
  const std::vector<Error> errors = nurbs::errors_of(curve, "the curve");
  for (const Error& e : errors) from.error(e.message);
  return errors.empty();
}

MaybeCurve outline_curve(const Reader& from) {
  const Whole whole{from};
  const std::vector<Vec3> points = from.points();
  const Real rounding = from.number("rounding");
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i].z != 0)
      from.error("points",
                 "found point " + std::to_string(i) + " off the plane, expected z = 0 of all");
  if (!whole.is_good()) return std::nullopt;
  return from.kept(nurbs::rounded_polygon(points, rounding));
}

MaybeCurve joined_curve(const Reading& reading, const Reader& from) {
  const Whole whole{from};
  std::vector<nurbs::Curve> curves;
  for (const NodeId node : from.items("curves"))
    if (auto curve = read_curve(reading, node)) curves.push_back(std::move(*curve));
  if (!whole.is_good()) return std::nullopt;
  return from.kept(nurbs::joined(curves));
}

MaybeCurve curve_of(const Reading& reading, CurveType type, const Reader& from) {
  const Whole whole{from};
  nurbs::Curve curve;
  switch (type) {
    case CurveType::nurbs:
      curve.knots = {from.whole("degree", 1), read_list(from, "knots"), from.flag("periodic")};
      curve.points = read_net(from);
      break;
    case CurveType::line:
      curve = nurbs::line(from.vec("from", Vec3(0)), from.vec("to", Vec3(1, 0, 0)));
      break;
    case CurveType::arc: {
      Real ends[2] = {0, 90};
      from.numbers("angles_deg", ends);
      if (!(ends[0] < ends[1] && ends[1] <= ends[0] + 360)) {
        from.error_value("angles_deg", "the second angle above the first, by at most 360");
        return std::nullopt;
      }
      const Real radian = kPi / 180;
      curve = nurbs::arc({}, from.number("radius", 1), {ends[0] * radian, ends[1] * radian});
      break;
    }
    case CurveType::circle:
      curve = nurbs::circle({}, from.number("radius", 1));
      break;
    case CurveType::ellipse: {
      Real radii[2] = {1, 1};
      from.numbers("radii", radii);
      curve = nurbs::ellipse({}, radii[0], radii[1]);
      break;
    }
    case CurveType::interpolation: {
      const std::vector<Vec3> points = from.points();
      const int degree = from.whole("degree");
      const auto ends = from.flag("closed") ? nurbs::Ends::periodic : nurbs::Ends::open;
      if (!whole.is_good()) return std::nullopt;
      auto made = from.kept(nurbs::interpolated(points, degree, ends));
      if (!made) return std::nullopt;
      curve = std::move(*made);
      break;
    }
    case CurveType::outline:
      return outline_curve(from);
    case CurveType::joined:
      return joined_curve(reading, from);
    default:  // outlines of machine parts
      return read_profile(type, from);
  }
  return whole.is_good() ? MaybeCurve(std::move(curve)) : std::nullopt;
}

MaybeCurve read_curve_at(const Reading& reading, const Reader& from, std::string_view key) {
  const NodeId node = from.find(key);
  return node == kNoNode ? std::nullopt : read_curve(reading, node);
}

// ---- Faces -------------------------------------------------------------------------------------

MaybeFace nurbs_face(const Reader& from) {
  nurbs::Surface face;
  const auto degrees = read_degrees(from, 1);
  face.u = {degrees[0], read_list(from, "knots_u"), from.flag("periodic_u")};
  face.v = {degrees[1], read_list(from, "knots_v"), from.flag("periodic_v")};
  face.points = read_net(from);
  return face;
}

MaybeFace cone_face(const Reader& from) {
  Real radii[2] = {1, 1};
  from.numbers("radii", radii);
  if (radii[0] == 0 && radii[1] == 0) {
    from.error_value("radii", "one of the radii above 0");
    return std::nullopt;
  }
  return nurbs::cone({}, {radii[0], radii[1]}, from.number("height", 1));
}

MaybeFace sweep_face(const Reading& reading, const Reader& from) {
  const auto section = read_curve_at(reading, from, "section");
  const auto path = read_curve_at(reading, from, "path");
  const bool is_turning = from.flag("turning");
  const int stations = from.whole("stations");
  if (!section || !path) return std::nullopt;
  return is_turning ? nurbs::swept_turning(*section, *path, stations)
                    : nurbs::swept(*section, *path);
}

MaybeFace interpolated_face(const Reader& from) {
  const std::vector<Vec3> points = from.points();
  const int columns = from.whole("columns", 2);
  const auto degrees = read_degrees(from, 3);
  if (points.size() % static_cast<std::size_t>(columns) != 0) {
    from.error("points", "found " + std::to_string(points.size()) +
                             " points, expected whole rows of " + std::to_string(columns));
    return std::nullopt;
  }
  return from.kept(nurbs::interpolated(nurbs::PointGrid{points, columns}, degrees));
}

MaybeFace face_of(const Reading& reading, FaceType type, const Reader& from) {
  switch (type) {
    case FaceType::nurbs:
      return nurbs_face(from);
    case FaceType::plane: {
      Real size[2] = {1, 1};
      from.numbers("size", size);
      return nurbs::plane({}, size[0], size[1]);
    }
    case FaceType::cylinder:
      return nurbs::cylinder({}, from.number("radius", 1), from.number("height", 1));
    case FaceType::cone:
      return cone_face(from);
    case FaceType::sphere:
      return nurbs::sphere({}, from.number("radius", 1));
    case FaceType::ellipsoid:
      return nurbs::ellipsoid({}, from.vec("radii", Vec3(1)));
    case FaceType::torus:
      return nurbs::torus({}, from.number("radius", 1), from.number("tube", 0.1));
    case FaceType::revolution: {
      const auto profile = read_curve_at(reading, from, "profile");
      const Real degrees = from.number("angle_deg");
      // Exactly a full circle, so that it closes.
      const Real angle = degrees == 360 ? 2 * kPi : degrees * (kPi / 180);
      return profile ? MaybeFace(nurbs::revolved(*profile, {}, angle)) : std::nullopt;
    }
    case FaceType::extrusion: {
      const auto profile = read_curve_at(reading, from, "profile");
      const Vec3 way = from.vec("way", Vec3(0, 0, 1));
      return profile ? MaybeFace(nurbs::extruded(*profile, way)) : std::nullopt;
    }
    case FaceType::sweep:
      return sweep_face(reading, from);
    case FaceType::interpolation:
      return interpolated_face(from);
  }
  return std::nullopt;
}

}  // namespace

std::optional<nurbs::Curve> read_curve(const Reading& reading, NodeId node) {
  const auto type = read_type(reading, node, kCurveTypes);
  if (!type) return std::nullopt;
  const Reader from = reading.open(node, std::string(kCurveTypes[*type]) + "_curve");
  const Whole whole{from};
  if (from.has("name")) from.name();
  auto curve = curve_of(reading, static_cast<CurveType>(*type), from);
  const nurbs::Affine by = placing_of(from);
  if (!curve || !whole.is_good() || !is_whole(from, *curve)) return std::nullopt;
  return from.has_any(kPlacing) ? nurbs::transformed(*curve, by) : *curve;
}

std::optional<nurbs::Surface> read_face(const Reading& reading, NodeId node) {
  const auto type = read_type(reading, node, kFaceTypes);
  if (!type) return std::nullopt;
  const Reader from = reading.open(node, std::string(kFaceTypes[*type]) + "_face");
  const Whole whole{from};
  auto face = face_of(reading, static_cast<FaceType>(*type), from);
  for (const NodeId loop : from.items("trims"))
    if (auto curve = read_curve(reading, loop); curve && face)
      face->trims.push_back(std::move(*curve));
  const bool is_turned = from.flag("inside_out");
  const nurbs::Affine by = placing_of(from);
  if (!face || !whole.is_good()) return std::nullopt;
  if (from.has_any(kPlacing)) *face = nurbs::transformed(*face, by);
  return is_turned ? turned(*face) : *face;
}

void read_curves(Reading& reading, const Reader& scene) {
  read_named(reading, scene.items("curves"), reading.curve_of, read_curve);
}

std::optional<nurbs::Curve> read_own_curve(const Reading& reading, const Reader& side) {
  const NodeId node = side.find("curve");
  if (node == kNoNode) return std::nullopt;
  const JsonNode& value = reading.json[node];
  if (value.kind == JsonKind::object) return read_curve(reading, node);
  if (value.kind == JsonKind::string)
    if (const auto known = reading.curve_of.find(value.text); known != reading.curve_of.end())
      return known->second;
  refuse_unknown(reading, node, reading.curve_of, "the name of a curve, or a curve");
  return std::nullopt;
}

}  // namespace pantin::detail
