// Curves that are outlines of machine parts.
#include "engine/scene/read/profile.hpp"

#include "engine/nurbs/profiles.hpp"
#include "engine/scene/json/words.hpp"

namespace pantin::detail {
namespace {

nurbs::Teeth teeth_of(const Reader& from) {
  nurbs::Teeth teeth;
  teeth.count = from.whole("teeth", teeth.count);
  teeth.module = from.number("module", teeth.module);
  teeth.pressure_angle = from.number("pressure_angle_deg") * kPi / 180;
  teeth.backlash = from.number("backlash");
  return teeth;
}

nurbs::GenevaDrive geneva_of(const Reader& from) {
  nurbs::GenevaDrive drive;
  drive.slots = from.whole("slots", drive.slots);
  drive.distance = from.number("distance", drive.distance);
  drive.pin_radius = from.number("pin", drive.pin_radius);
  drive.lip = from.number("lip", drive.pin_radius / 3);
  drive.clearance = from.number("clearance");
  return drive;
}

nurbs::Cam cam_of(const Reader& from) {
  nurbs::Cam cam;
  cam.base = from.number("base", cam.base);
  cam.roller = from.has("roller") ? from.number("roller", 0) : -1;
  cam.law = static_cast<nurbs::CamLaw>(from.word("law"));
  for (const NodeId node : from.items("lifts")) {
    std::array<Real, 2> pair{};
    if (!from.numbers_at(node, pair, kAnyNumber)) continue;
    const Real angle = pair[0] * kPi / 180;
    if (!cam.lifts.empty() &&
        (angle <= cam.lifts.back()[0] || angle - cam.lifts.front()[0] >= 2 * kPi))
      from.diagnostics.error(node, "found an angle of " + written(pair[0]) +
                                       " degrees, expected angles in order within one turn");
    cam.lifts.push_back({angle, pair[1]});
  }
  return cam;
}

}  // namespace

std::optional<nurbs::Curve> read_profile(CurveType type, const Reader& from) {
  const std::size_t refused_before = from.diagnostics.error_count();
  const auto made = [&]() -> Result<nurbs::Curve> {
    switch (type) {
      case CurveType::gear:
        return nurbs::involute_gear(teeth_of(from));
      case CurveType::rack:
        return nurbs::involute_rack(teeth_of(from), from.number("back", 1));
      case CurveType::cam:
        return nurbs::cam_outline(cam_of(from));
      case CurveType::geneva_wheel:
        return nurbs::geneva_wheel(geneva_of(from));
      case CurveType::geneva_disc:
        return nurbs::geneva_disc(geneva_of(from));
      default:  // a helix: read_curve() leaves no other
        return nurbs::helix(
            {from.number("radius", 1), from.number("pitch", 1), from.number("turns", 1)});
    }
  }();
  if (from.diagnostics.error_count() != refused_before) return std::nullopt;
  return from.kept(made);
}

}  // namespace pantin::detail
