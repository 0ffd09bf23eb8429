#include "engine/world/lamina.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/invariants.hpp"
#include "engine/base/rotation.hpp"
#include "engine/world/flat.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {
namespace {

constexpr std::size_t kMostFingers = 32;
constexpr Real kUpright = 1e-6;

bool is_friction(Real mu) { return mu >= 0 && std::isfinite(mu); }

bool is_sound(const LaminaFinger& f) {
  const auto later = [](const FingerKey& a, const FingerKey& b) { return !(a.time < b.time); };
  const auto none = [](const FingerKey& k) { return !std::isfinite(k.time) || !is_finite(k.at); };
  return is_friction(f.roll) && is_friction(f.slide) && is_finite(f.point) && is_finite(f.normal) &&
         is_unit(f.normal) && std::none_of(f.path.begin(), f.path.end(), none) &&
         std::adjacent_find(f.path.begin(), f.path.end(), later) == f.path.end();
}

Real twice_area(const std::vector<Vec3>& corners) {
  Real sum = 0;
  for (std::size_t i = 0; i < corners.size(); ++i)
    sum += glm::cross(corners[i], corners[(i + 1) % corners.size()]).z;
  return sum;
}

}  // namespace

const char* Lamina::restored() const {
  if (outline.size() < 3 ||
      !std::all_of(outline.begin(), outline.end(), [](Vec3 p) { return is_finite(p); }) ||
      !(twice_area(outline) > 0))
    return "is a lamina whose outline encloses no area";
  if (fingers.size() > kMostFingers) return "is a lamina with more than 32 fingers";
  if (!std::all_of(fingers.begin(), fingers.end(), is_sound))
    return "is a lamina with a finger that has a number that is not finite or out of range";
  return nullptr;
}

Store<Lamina>& laminas_of(World& world) { return world.user.of<Lamina>(); }
const Store<Lamina>* laminas_of(const World& world) { return world.user.find<Lamina>(); }

std::string lamina_fault(const World& world, Entity body) {
  const Store<Lamina>* all = laminas_of(world);
  const Lamina* lamina = all ? all->find(body) : nullptr;
  if (!lamina) return "is solved by \"quasistatic\", which moves laminas only";
  if (const char* why = lamina->restored()) return why;
  const Body& b = world.bodies[body];
  const Quat q = b.pose.rotation;
  if (std::hypot(q.x, q.y) > kUpright) return "is a lamina that does not lie in the xy plane";
  for (const LaminaFinger& f : lamina->fingers) {
    const Body* finger = world.bodies.find(f.body);
    if (finger && finger->motion != Motion::kinematic)
      return "is a lamina with a finger that is not kinematic";
  }
  return flat_fault(b);
}

FingerMotion motion_of(const std::vector<FingerKey>& path, Real time) {
  constexpr Real kNever = std::numeric_limits<Real>::infinity();
  if (path.empty()) return {Vec3(0), Vec3(0), kNever};
  const auto after = std::upper_bound(path.begin(), path.end(), time,
                                      [](Real t, const FingerKey& k) { return t < k.time; });
  if (after == path.begin()) return {path.front().at, Vec3(0), path.front().time};
  if (after == path.end()) return {path.back().at, Vec3(0), kNever};
  const FingerKey &a = *(after - 1), &b = *after;
  const Vec3 velocity = (b.at - a.at) / (b.time - a.time);
  return {a.at + (time - a.time) * velocity, velocity, b.time};
}

void move_fingers(World& world, Real until, Real h) {
  const Store<Lamina>* all = laminas_of(std::as_const(world));
  if (!all) return;
  for (const Lamina& lamina : all->values())
    for (const LaminaFinger& f : lamina.fingers) {
      Body* b = f.path.empty() ? nullptr : world.bodies.find(f.body);
      if (!b || b->motion != Motion::kinematic) continue;
      const Vec3 to = motion_of(f.path, until).at - b->pose.rotation * f.point;
      b->velocity = (to - b->pose.position) / h, b->angular_velocity = Vec3(0);
      b->pose.position = to;
    }
}

}  // namespace pantin::detail
