// Sensors: looks up what they measure.
#include "engine/joints/kinds.hpp"
#include "engine/scene/build/group_builder.hpp"
#include "engine/scene/build/place.hpp"
#include "engine/scene/keys/keys.hpp"

namespace pantin::detail {

void GroupBuilder::add_sensor(Element<SensorRecipe> e) {
  const SensorRecipe& r = e.recipe;
  BuiltSensor made{{r.name, r.kind}, kWorldBody, kWorldBody, kWorldBody, 0};
  bool good = true;
  struct Place {
    std::uint32_t& body;
    SensorPoint& point;
  };
  const auto place = [&](std::string_view member, const std::string& name, Vec3 anchor, Place at) {
    if (name.empty()) return;
    const auto found = body_or_world(name, e.id, member);
    good = good && found;
    if (found) at.body = *found, at.point.at = from_own_frame(made_, at.body, anchor);
  };
  made.sensor.by_points = r.kind == SensorKind::angle && !r.from.empty();
  const Place first{made.a, made.sensor.a}, second{made.b, made.sensor.b},
      third{made.c, made.sensor.c};
  place("body", r.body, r.anchor, first), place("from", r.from, r.from_anchor, second);
  place("to", r.to, r.to_anchor, made.sensor.by_points ? third : second);
  if (!r.joint.empty()) {
    const auto* joints =
        look_up_all(EventObject::joint, r.joint, {e.id, "joint", "the name of a joint"});
    if (joints && joints->size() > 1)
      messages_.error(
          e.id, "joint",
          "found " + quoted_name(r.joint) + ", which several joints belong to, expected one joint");
    good = good && joints && joints->size() == 1;
    if (good) made.joint = joints->front();
    if (good && r.kind == SensorKind::motor) {
      const BuiltJoint& j = made_.joints[made.joint];
      if (!keys::acts(info_of(j.joint.kind))) {
        messages_.error(
            e.id, "joint",
            "found " + a_joint(j.joint.kind) + " " + quoted_name(j.name) +
                ", expected one of a kind that can have a motor: " + kinds_where(keys::acts));
        return;
      }
    }
  }
  if (good) made_.sensors.push_back(std::move(made));
}

}  // namespace pantin::detail
