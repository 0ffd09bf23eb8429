#include "engine/world/surface_contact.hpp"

#include <cmath>
#include <utility>

#include "engine/base/invariants.hpp"

namespace pantin::detail {

bool is_on(const ContactSurface& surface, const nurbs::Place& place) {
  if (surface.curve) return surface.curve->knots().domain().holds(place.u);
  if (!surface.skin || place.face < 0 ||
      std::cmp_greater_equal(place.face, surface.skin->faces().size()))
    return false;
  const nurbs::Face& face = surface.skin->face(place.face);
  return face.u().domain().holds(place.u) && face.v().domain().holds(place.v) &&
         face.holds(place.u, place.v);
}

const char* SurfaceContact::restored() const {
  for (const ContactSurface* one : {&on_a, &on_b}) {
    if (!one->skin == !one->curve) return "has not exactly one surface or curve on each side";
    if (!is_unit(one->pose)) return "has a surface whose rotation is not a unit quaternion";
  }
  if (on_b.curve && !on_a.curve) return "has a curve on b but none on a";
  if (known && !(is_on(on_a, at.a) && is_on(on_b, at.b)))
    return "has a contact point off its surfaces";
  if (!std::isfinite(friction)) return "has a friction that is not finite";
  if (spots < 1 || spots > kMostSpots || (spots > 1 && !lifts))
    return "has a number of contact points that is out of range";
  return nullptr;
}

}  // namespace pantin::detail
