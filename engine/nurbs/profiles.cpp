#include "engine/nurbs/profiles.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "engine/nurbs/makers.hpp"
#include "engine/nurbs/plane_curves.hpp"

namespace pantin::detail::nurbs {
namespace {

constexpr int kFlankPieces = 8;
constexpr Real kFlankStart = 0.04;  // least tangent of the pressure angle on a flank
constexpr Real kTip = 0.1, kRoot = 0.38, kAbove = 1, kBelow = 1.25;  // modules
constexpr int kBisections = 80;
constexpr int kCamPoints = 720;          // in a turn
constexpr int kHelixPoints = 32;         // in a turn
constexpr Real kRecess = 0.003 / 0.012;  // of the pin's radius, between a disc and the wheel
constexpr Real kFillet = 0.5;            // of the pin's radius, of the disc's corners

std::string shown(Real x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", x);
  return text;
}

Vec3 polar(Real radius, Real angle) {
  return {radius * std::cos(angle), radius * std::sin(angle), 0};
}
Real angle_of(Vec3 p) { return std::atan2(p.y, p.x); }
Curve turned(const Curve& curve, Real angle) {
  const Real c = std::cos(angle), s = std::sin(angle);
  return transformed(curve, {Mat3(c, s, 0, -s, c, 0, 0, 0, 1), Vec3(0)});
}
/// Across the x axis.
Curve flipped(const Curve& curve) {
  return reversed(transformed(curve, {Mat3(1, 0, 0, 0, -1, 0, 0, 0, 1), Vec3(0)}));
}
/// The shorter arc about a centre from one point to another.
Curve arc_between(Vec3 centre, Vec3 from, Vec3 to) {
  const Real radius = glm::distance(from, centre), begin = angle_of(from - centre);
  const Real turn = std::remainder(angle_of(to - centre) - begin, 2 * kPi);
  if (turn > 0) return arc({centre}, radius, {begin, begin + turn});
  return reversed(arc({centre}, radius, {begin + turn, begin}));
}

/// Finds where a function that is below 0 at `low` and not at `high` changes sign.
template <class Function>
Real change_of_sign(Real low, Real high, const Function& f) {
  for (int round = 0; round < kBisections; ++round) {
    const Real middle = (low + high) / 2;
    (f(middle) < 0 ? low : high) = middle;
  }
  return (low + high) / 2;
}

/// The upper flank of the tooth along x, by the tangent t of the pressure angle at a point.
class Flank {
 public:
  explicit Flank(const Teeth& teeth) {
    const Real tangent = std::tan(teeth.pressure_angle);
    base_ = pitch(teeth) * std::cos(teeth.pressure_angle);
    start_ = kPi / (2 * teeth.count) - teeth.backlash / (4 * pitch(teeth)) + tangent -
             teeth.pressure_angle;
  }
  static Real pitch(const Teeth& teeth) { return teeth.count * teeth.module / 2; }
  Real base() const { return base_; }
  Real at_radius(Real radius) const {
    return std::sqrt(std::max((radius / base_) * (radius / base_) - 1, 0.0));
  }
  /// e: along the tangent, at the roll angle.
  Vec3 along(Real t) const { return polar(1, start_ - t); }
  /// Out of the tooth.
  Vec3 normal(Real t) const { return {-along(t).y, along(t).x, 0}; }
  /// R (e + t n), whose derivatives are R t e and R (e - t n).
  Vec3 point(Real t) const { return base_ * (along(t) + t * normal(t)); }
  /// The part between two tangents: pieces of degree 5 with the exact derivatives to order 2 at
  /// their ends.
  Curve curve(Real from, Real to) const {
    Curve made{{5, {}}, {}};
    const Real h = (to - from) / kFlankPieces;
    made.knots.values.assign(6, 0);
    made.points.emplace_back(point(from), 1);
    for (int i = 0; i < kFlankPieces; ++i) {
      const Real a = from + i * h, b = i + 1 < kFlankPieces ? a + h : to;
      const auto add = [&](Real t, Real first, Real second) {
        made.points.emplace_back(point(t) + base_ * (first * h * t * along(t) +
                                                     second * h * h * (along(t) - t * normal(t))),
                                 1);
      };
      add(a, 0.2, 0), add(a, 0.4, 0.05), add(b, -0.4, 0.05), add(b, -0.2, 0), add(b, 0, 0);
      for (int k = 0; k < 5; ++k) made.knots.values.push_back(i + 1);
    }
    made.knots.values.push_back(kFlankPieces);
    return made;
  }

 private:
  Real base_, start_;
};

/// The half of a tooth from the middle of its gap to the middle of its tip, anticlockwise reversed:
/// from the tip down.
struct ToothSide {
  Vec3 tip_end, flank_end, foot;  // where the tip's circle, the flank and the radius end
  Vec3 tip_centre, root_centre;   // of the roundings
  Vec3 root_end;
  Real t_high, t_low;  // of the flank
};

std::optional<ToothSide> side_of(const Teeth& teeth, const Flank& flank) {
  const Real m = teeth.module, pitch = Flank::pitch(teeth);
  const Real tip = pitch + kAbove * m, root = pitch - kBelow * m, half_pitch = kPi / teeth.count;
  ToothSide s{};
  for (Real rounding = kRoot * m;; rounding /= 2) {
    if (rounding < 1e-3 * m) return std::nullopt;
    // The rounding that touches the root circle and the flank where it begins.
    const auto fits = [&](Real t) {
      const Vec3 p = flank.point(t), n = flank.normal(t);
      return (glm::dot(p, p) - root * root) / (2 * (root - glm::dot(p, n))) - rounding;
    };
    if (fits(kFlankStart) >= 0) {
      // Along the tangent to where the rounding begins.
      s.t_low = kFlankStart;
      s.flank_end = flank.point(s.t_low);
      const Vec3 way = flank.along(s.t_low), out = rounding * flank.normal(s.t_low);
      const Vec3 from = s.flank_end + out;
      const Real slope = glm::dot(from, way), reach = root + rounding;
      const Real way_down =
          slope - std::sqrt(std::max(slope * slope - glm::dot(from, from) + reach * reach, 0.0));
      s.foot = s.flank_end - way_down * way;
      s.root_centre = s.foot + out;
    } else {
      const Real high = flank.at_radius(pitch);
      if (fits(high) < 0) continue;
      s.t_low = change_of_sign(kFlankStart, high, fits);
      s.flank_end = s.foot = flank.point(s.t_low);
      s.root_centre = s.foot + rounding * flank.normal(s.t_low);
    }
    s.root_end = root * glm::normalize(s.root_centre);
    if (angle_of(s.root_centre) < half_pitch * (1 - 1e-6)) break;
  }
  const Real rounding = kTip * m;
  const auto reaches = [&](Real t) {
    return glm::length(flank.point(t) - rounding * flank.normal(t)) - (tip - rounding);
  };
  s.t_high = change_of_sign(flank.at_radius(pitch), flank.at_radius(tip), reaches);
  s.tip_centre = flank.point(s.t_high) - rounding * flank.normal(s.t_high);
  s.tip_end = tip * glm::normalize(s.tip_centre);
  if (angle_of(s.tip_end) <= 1e-9) return std::nullopt;
  return s;
}

}  // namespace

Result<Curve> involute_gear(const Teeth& teeth) {
  const Flank flank(teeth);
  const auto side = side_of(teeth, flank);
  if (!side)
    return Error{"found " + std::to_string(teeth.count) + " teeth at a pressure angle of " +
                 shown(teeth.pressure_angle * 180 / kPi) +
                 " degrees, expected teeth that are not pointed, with gaps between them"};
  // From the middle of the tip to the root.
  std::vector<Curve> down{arc_between(side->tip_centre, side->tip_end, flank.point(side->t_high)),
                          flank.curve(side->t_high, side->t_low)};
  if (glm::distance(side->flank_end, side->foot) > 1e-9 * flank.base())
    down.push_back(line(side->flank_end, side->foot));
  down.push_back(arc_between(side->root_centre, side->foot, side->root_end));
  const Real gap = 2 * kPi / teeth.count, root = glm::length(side->root_end);
  std::vector<Curve> all;
  for (int k = 0; k < teeth.count; ++k) {
    const auto add = [&](const Curve& c) { all.push_back(turned(c, gap * k)); };
    for (auto c = down.rbegin(); c != down.rend(); ++c) add(flipped(*c));
    const Real tip = angle_of(side->tip_end);
    add(arc({}, glm::length(side->tip_end), {-tip, tip}));
    for (const Curve& c : down) add(c);
    const Real from = angle_of(side->root_end);
    add(arc({}, root, {from, gap - from}));
  }
  auto made = joined(all);
  if (made && !made->knots.is_periodic) made->knots.is_periodic = true;
  return made;
}

Result<Curve> involute_rack(const Teeth& teeth, Real back) {
  const Real m = teeth.module, pitch = kPi * m, lean = std::tan(teeth.pressure_angle);
  const Real half = pitch / 4 - teeth.backlash / 4, high = kAbove * m, low = kBelow * m;
  const Real first = -(teeth.count - 1) / 2 * pitch;
  if (half - high * lean <= kTip * m)
    return Error{"found teeth at a pressure angle of " + shown(teeth.pressure_angle * 180 / kPi) +
                 " degrees, expected teeth that are not pointed"};
  if (!(back > low))
    return Error{"found a back " + shown(back) + " m below the pitch line, expected more than " +
                 shown(low) + " m"};
  const Real last = first + (teeth.count - 1) * pitch;
  std::vector<Vec3> points{{last + pitch / 2, -back, 0}, {last + pitch / 2, -low, 0}};
  for (int k = teeth.count - 1; k >= 0; --k) {
    const Real x = first + k * pitch;
    for (const auto& [side, y] : {std::pair{1, -low}, {1, high}, {-1, high}, {-1, -low}})
      points.push_back({x + side * (half - y * lean), y, 0});
  }
  points.push_back({first - pitch / 2, -low, 0});
  points.push_back({first - pitch / 2, -back, 0});
  return rounded_polygon(points, kTip * m);
}

Real GenevaDrive::arm() const { return distance * std::sin(kPi / slots); }

Result<Curve> geneva_wheel(const GenevaDrive& d) {
  const Real arm = d.arm(), reach = d.distance * std::cos(kPi / d.slots);
  const Real bottom = d.distance - arm - 2 * d.pin_radius / 3;
  const Real lock = arm - d.pin_radius - 2 * d.lip, slot = 2 * kPi / d.slots;
  if (!(bottom * std::sin(slot / 2) > d.pin_radius) || !(lock > 0))
    return Error{"found a pin of " + shown(d.pin_radius) + " m for " + std::to_string(d.slots) +
                 " slots at a distance of " + shown(d.distance) +
                 " m, expected a thinner one, between whose slots there is some wheel"};
  std::vector<Curve> all;
  for (int k = 0; k < d.slots; ++k) {
    const auto add = [&](const Curve& c) { all.push_back(turned(c, slot * k)); };
    add(line({reach, -d.pin_radius, 0}, {bottom, -d.pin_radius, 0}));
    add(reversed(arc({{bottom, 0, 0}}, d.pin_radius, {kPi / 2, 3 * kPi / 2})));
    add(line({bottom, d.pin_radius, 0}, {reach, d.pin_radius, 0}));
    add(arc({{reach, d.pin_radius + d.lip, 0}}, d.lip, {-kPi / 2, kPi / 2}));
    // About the crank's axis while the wheel rests.
    add(reversed(arc({{reach, arm, 0}}, lock, {kPi / 2 + slot, 3 * kPi / 2})));
    const Curve lip = arc({{reach, -d.pin_radius - d.lip, 0}}, d.lip, {-kPi / 2, kPi / 2});
    all.push_back(turned(lip, slot * (k + 1)));
  }
  return joined(all);
}

Result<Curve> geneva_disc(const GenevaDrive& d) {
  const Real arm = d.arm(), reach = d.distance * std::cos(kPi / d.slots);
  const Real radius = arm - d.pin_radius - 2 * d.lip - d.clearance;
  const Real recess = std::hypot(reach, d.pin_radius + d.lip) + d.lip + kRecess * d.pin_radius;
  const Real fillet = kFillet * d.pin_radius;
  // The rounding is inside the disc and outside the recess.
  const Real a = radius - fillet, b = recess + fillet;
  const Real x = (d.distance * d.distance + a * a - b * b) / (2 * d.distance);
  const Real y = std::sqrt(a * a - x * x);
  if (!(y > fillet))
    return Error{
        "found a Geneva drive of " + std::to_string(d.slots) +
        " slots whose disc does not reach its wheel, expected more slots or a thinner pin"};
  const Vec3 centre(x, y, 0), wheel(d.distance, 0, 0);
  const Vec3 on_disc = radius / a * centre;
  const Vec3 on_recess = wheel + recess / b * (centre - wheel);
  const Curve corner = arc_between(centre, on_recess, on_disc);
  const Real begin = angle_of(on_disc), side = angle_of(on_recess - wheel);
  const Curve parts[] = {arc({}, radius, {begin, 2 * kPi - begin}), flipped(corner),
                         reversed(arc({wheel}, recess, {side, 2 * kPi - side})), corner};
  return joined(parts);
}

std::array<Real, 3> Cam::lift(Real angle) const {
  if (lifts.empty()) return {0, 0, 0};
  const Real first = lifts.front()[0];
  Real at = std::fmod(angle - first, 2 * kPi);
  at = first + (at < 0 ? at + 2 * kPi : at);
  std::size_t k = 0;
  while (k + 1 < lifts.size() && lifts[k + 1][0] <= at) ++k;
  const bool is_last = k + 1 == lifts.size();
  const auto [from, low] = lifts[k];
  const Real to = is_last ? first + 2 * kPi : lifts[k + 1][0];
  const Real high = is_last ? lifts.front()[1] : lifts[k + 1][1];
  const Real width = to - from, x = (at - from) / width, rise = high - low;
  std::array<Real, 3> s{};
  if (law == CamLaw::cycloidal)
    s = {x - std::sin(2 * kPi * x) / (2 * kPi), 1 - std::cos(2 * kPi * x),
         2 * kPi * std::sin(2 * kPi * x)};
  else
    s = {x * x * x * (10 + x * (6 * x - 15)), 30 * x * x * (1 - x) * (1 - x),
         60 * x * (1 - x) * (1 - 2 * x)};
  return {low + rise * s[0], rise * s[1] / width, rise * s[2] / (width * width)};
}

Result<Curve> cam_outline(const Cam& cam) {
  std::vector<Vec3> points;
  for (int i = 0; i < kCamPoints; ++i) {
    const Real angle = 2 * kPi * i / kCamPoints;
    const auto [s, slope, bend] = cam.lift(angle);
    const Vec3 out = polar(1, angle), along(-out.y, out.x, 0);
    const bool is_flat = cam.roller < 0;
    const Real r = cam.base + s + (is_flat ? 0 : cam.roller);
    // The radius of curvature of the outline; of the roller's path less the roller.
    const Real speed = std::hypot(r, slope);
    const Real turning = r * r + 2 * slope * slope - r * bend;
    const Real round = is_flat ? r + bend : speed * speed * speed / turning - cam.roller;
    if (!(is_flat ? round > 0 : turning <= 0 || round > 0))
      return Error{"found a cam that is " + std::string(is_flat ? "hollow" : "undercut") +
                   " where the follower is at " + shown(angle * 180 / kPi) +
                   " degrees, expected a larger base, a smaller lift" +
                   (is_flat ? "" : ", or a smaller roller")};
    points.push_back(is_flat ? r * out + slope * along
                             : r * out - cam.roller / speed * (r * out - slope * along));
  }
  return interpolated(points, 3, Ends::periodic);
}

Result<Curve> helix(const Helix& of) {
  const int count = std::max(8, static_cast<int>(std::ceil(of.turns * kHelixPoints))) + 1;
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const Real share = Real(i) / (count - 1);
    points.push_back(polar(of.radius, 2 * kPi * of.turns * share) +
                     Vec3(0, 0, of.pitch * of.turns * share));
  }
  return interpolated(points, 5, Ends::open);
}

}  // namespace pantin::detail::nurbs
