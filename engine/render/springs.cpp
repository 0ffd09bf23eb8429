#include "engine/render/springs.hpp"

#include <algorithm>

#include "engine/joints/kinds.hpp"
#include "engine/render/supports.hpp"

namespace pantin::detail {
namespace {

constexpr int kTurns = 8;
constexpr Real kEnds = 0.1;       // of the length: straight at each end
constexpr Real kRadius = 0.07;    // of the coil, relative to the rest length
constexpr Real kLeastRest = 0.3;  // of the present length, for springs that rest at no length
constexpr Real kWire = 0.24;      // relative to the radius of the coil

}  // namespace

std::optional<Coil> coil_of(const PosedWorld& scene, const Link& link) {
  if (link.joint.kind != JointKind::spring) return std::nullopt;
  const auto a = scene.position_of(link.a, link.joint.anchor_a);
  const auto b = scene.position_of(link.b, link.joint.anchor_b);
  if (!a || !b) return std::nullopt;
  const Real now = glm::distance(*a, *b);
  const Real rest = std::max(link.joint.parameters->length, kLeastRest * now);
  if (!(now > 1e-9) || !std::isfinite(rest)) return std::nullopt;
  return Coil{*a, *b, kRadius * rest, kWire * kRadius * rest};
}

std::vector<Vec3> wire_of(const Coil& coil, int around) {
  const Vec3 way = coil.b - coil.a;
  const Quat turn = upright(glm::normalize(way));
  std::vector<Vec3> points{coil.a};
  const int count = kTurns * around;
  for (int i = 0; i <= count; ++i) {
    const Real part = static_cast<Real>(i) / count, angle = 2 * kPi * kTurns * part;
    const Vec3 out = turn * Vec3(std::cos(angle), 0, std::sin(angle));
    points.push_back(coil.a + (kEnds + (1 - 2 * kEnds) * part) * way + coil.radius * out);
  }
  points.push_back(coil.b);
  return points;
}

}  // namespace pantin::detail
