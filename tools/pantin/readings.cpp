#include "tools/pantin/readings.hpp"

#include <cmath>
#include <limits>
#include <pantin/measure.hpp>

#include "engine/world/world.hpp"

namespace pantin::program {

using namespace detail;

namespace {

constexpr Real kNoNumber = std::numeric_limits<Real>::quiet_NaN();
constexpr const char* kAxes = "xyz";

/// Adds the three components of a vector, as PREFIXx to PREFIXz.
template <typename Vector>
void add_vector(std::vector<Reading>& to, const std::string& prefix, Vector vector) {
  for (int k = 0; k < 3; ++k)
    to.push_back({prefix + kAxes[k], [vector, k](const World& w) { return vector(w)[k]; }});
}

void add_joint(std::vector<Reading>& to, const World& world, Entity joint) {
  using Coordinate = Real (*)(const World&, Entity);
  const std::string name = world.name_of(joint);
  const std::pair<const char*, Coordinate> coordinates[] = {{"angle", joint_angle},
                                                            {"second_angle", joint_second_angle},
                                                            {"angular_speed", joint_angular_speed},
                                                            {"travel", joint_travel},
                                                            {"speed", joint_speed}};
  for (const auto& [what, coordinate] : coordinates)
    if (!std::isnan(coordinate(world, joint)))  // the joint has it
      to.push_back({name + '.' + what,
                    [joint, read = coordinate](const World& w) { return read(w, joint); }});
  add_vector(to, name + ".reaction_f", [joint](const World& w) {
    const auto reaction = joint_reaction(w, joint);
    return reaction ? reaction->force : Vec3(kNoNumber);
  });
  add_vector(to, name + ".reaction_t", [joint](const World& w) {
    const auto reaction = joint_reaction(w, joint);
    return reaction ? reaction->torque : Vec3(kNoNumber);
  });
}

void add_contacts(std::vector<Reading>& to, const std::string& name, Entity body,
                  const std::pair<const ContactEvents&, Real>& seen) {
  const auto& [events, step] = seen;
  add_vector(to, name + ".contact_f", [body, &events = events, step = step](const World&) {
    Vec3 impulse{0};
    for (const ContactEvent& e : events.events()) {
      if (e.phase == ContactPhase::end || e.is_sensor) continue;
      if (e.a == body) impulse += e.impulse;
      if (e.b == body) impulse -= e.impulse;
    }
    return impulse / step;
  });
  to.push_back({name + ".contacts", [body, &events = events](const World&) {
                  Real count = 0;
                  for (const ContactEvent& e : events.events())
                    count += e.phase != ContactPhase::end &&
                             (e.a == body || (e.b == body && !e.is_sensor));
                  return count;
                }});
}

}  // namespace

std::vector<Reading> readings_of(const World& world, const ContactEvents& events, Real step) {
  std::vector<Reading> all;
  for (const Entity e : world.links.owners()) add_joint(all, world, e);
  for (const Entity e : world.cables.owners())
    all.push_back(
        {world.name_of(e) + ".tension", [e](const World& w) { return cable_tension(w, e); }});
  for (const Entity e : world.pins.owners())
    add_vector(all, world.name_of(e) + ".pin_f",
               [e](const World& w) { return pin_force(w, e).value_or(Vec3(kNoNumber)); });
  for (const Entity e : world.bodies.owners())
    if (world.collisions.find(e)) add_contacts(all, world.name_of(e), e, {events, step});
  return all;
}

}  // namespace pantin::program
