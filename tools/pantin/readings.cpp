#include "tools/pantin/readings.hpp"

#include <cmath>
#include <limits>
#include <pantin/measure.hpp>

#include "engine/world/lamina.hpp"
#include "engine/world/world.hpp"

namespace pantin::program {

using namespace detail;

namespace {

constexpr Real kNoNumber = std::numeric_limits<Real>::quiet_NaN();
constexpr const char* kAxes = "xyz";

/// Adds the three components of a vector, as PREFIXx to PREFIXz.
template <typename Vector>
void add_vector(std::vector<Reading>& to, const std::string& prefix, const char* unit,
                Vector vector) {
  for (int k = 0; k < 3; ++k)
    to.push_back({prefix + kAxes[k], unit, [vector, k](const World& w) { return vector(w)[k]; }});
}

/// A coordinate of a joint, or its rate.
struct CoordinateColumn {
  const char *name, *unit;
  Real (*of)(const World&, Entity);
  Real (*rate)(const World&, Entity) = nullptr;  // of an angle, if it can go round
};
constexpr CoordinateColumn kCoordinates[] = {{"angle", "rad", joint_angle, joint_angular_speed},
                                             {"second_angle", "rad", joint_second_angle},
                                             {"angular_speed", "rad/s", joint_angular_speed},
                                             {"travel", "m", joint_travel},
                                             {"speed", "m/s", joint_speed}};

/// An angle with whole turns counted from the first reading on, by its rate: rows may be many steps
/// apart.
class CountedAngle {
 public:
  CountedAngle(Entity joint, const CoordinateColumn& column)
      : joint_(joint), read_(column.of), rate_(column.rate) {}
  Real operator()(const World& w) {
    constexpr Real kTurn = 2 * kPi;
    const Real now = read_(w, joint_), rate = rate_ ? rate_(w, joint_) : 0;
    const bool goes_on = w.time >= time_ && std::isfinite(last_);
    const Real meant = goes_on ? last_ + 0.5 * (last_rate_ + rate) * (w.time - time_) : now;
    last_ = now + kTurn * std::round((meant - now) / kTurn);
    time_ = w.time, last_rate_ = rate;
    return last_;
  }

 private:
  Entity joint_;
  Real (*read_)(const World&, Entity);
  Real (*rate_)(const World&, Entity);
  Real last_ = kNoNumber, last_rate_ = 0, time_ = 0;
};

void add_joint(std::vector<Reading>& to, const World& world, Entity joint) {
  const std::string name = world.name_of(joint);
  for (const CoordinateColumn& column : kCoordinates)
    if (!std::isnan(column.of(world, joint))) {  // the joint has it
      std::function<Real(const World&)> read = [joint, of = column.of](const World& w) {
        return of(w, joint);
      };
      if (column.rate) read = CountedAngle(joint, column);
      to.push_back({name + '.' + column.name, column.unit, std::move(read)});
    }
  const bool is_torque = !std::isnan(motor_force(world, joint, JointCoordinate::angle));
  if (!std::isnan(motor_force(world, joint)))
    to.push_back({name + ".motor", is_torque ? "N m" : "N",
                  [joint](const World& w) { return motor_force(w, joint); }});
  add_vector(to, name + ".reaction_f", "N", [joint](const World& w) {
    const auto reaction = joint_reaction(w, joint);
    return reaction ? reaction->force : Vec3(kNoNumber);
  });
  add_vector(to, name + ".reaction_t", "N m", [joint](const World& w) {
    const auto reaction = joint_reaction(w, joint);
    return reaction ? reaction->torque : Vec3(kNoNumber);
  });
}

void add_motion(std::vector<Reading>& to, const std::string& name, Entity body) {
  for (std::size_t i = 0; i < std::size(kBodyColumns); ++i)
    if (*kBodyColumns[i].unit)  // not the quaternion
      to.push_back({name + '.' + kBodyColumns[i].name, kBodyColumns[i].unit,
                    [body, i](const World& w) { return columns_of_body(w, body)[i]; }});
}

void add_contacts(std::vector<Reading>& to, const std::string& name, Entity body,
                  const std::pair<const ContactEvents&, Real>& seen) {
  const auto& [events, step] = seen;
  add_vector(to, name + ".contact_f", "N", [body, &events = events, step = step](const World&) {
    Vec3 impulse{0};
    for (const ContactEvent& e : events.events()) {
      if (e.phase == ContactPhase::end || e.is_sensor) continue;
      if (e.a == body) impulse += e.impulse;
      if (e.b == body) impulse -= e.impulse;
    }
    return impulse / step;
  });
  to.push_back({name + ".contacts", "", [body, &events = events](const World&) {
                  Real count = 0;
                  for (const ContactEvent& e : events.events())
                    count += e.phase != ContactPhase::end &&
                             (e.a == body || (e.b == body && !e.is_sensor));
                  return count;
                }});
}

/// Contact forces of laminas and their fingers are of another kind: see `pantin modes`.
bool has_contact_readings(const World& world, Entity e) {
  const Store<Lamina>* laminas = laminas_of(world);
  return world.collisions.find(e) && (!laminas || laminas->size() == 0);
}

/// Joints, cables and pins.
void add_connection(std::vector<Reading>& to, const World& world, Entity e) {
  const std::string name = world.name_of(e);
  if (world.links.find(e)) add_joint(to, world, e);
  if (world.cables.find(e))
    to.push_back({name + ".tension", "N", [e](const World& w) { return cable_tension(w, e); }});
  if (world.pins.find(e))
    add_vector(to, name + ".pin_f", "N",
               [e](const World& w) { return pin_force(w, e).value_or(Vec3(kNoNumber)); });
}

}  // namespace

std::array<Real, std::size(kBodyColumns)> columns_of_body(const World& world, Entity body) {
  std::array<Real, std::size(kBodyColumns)> all;
  all.fill(kNoNumber);
  const Body* b = world.bodies.find(body);
  if (!b) return all;
  const Pose at = world.origin_pose(body);
  const Vec3 p = at.position, v = b->velocity, w = b->angular_velocity;
  const Quat q = at.rotation;
  return {p.x, p.y, p.z, q.x, q.y, q.z, q.w, v.x, v.y, v.z, w.x, w.y, w.z};
}

std::vector<Reading> readings_of(const World& world, const ContactEvents& events, Real step) {
  std::vector<Reading> all;
  for (const Entity e : world.links.owners()) add_connection(all, world, e);
  for (const Entity e : world.cables.owners()) add_connection(all, world, e);
  for (const Entity e : world.pins.owners()) add_connection(all, world, e);
  for (const Entity e : world.bodies.owners())
    if (has_contact_readings(world, e)) add_contacts(all, world.name_of(e), e, {events, step});
  return all;
}

std::vector<Reading> readings_of(const World& world, Entity object, const ContactEvents& events,
                                 Real step) {
  std::vector<Reading> all;
  add_connection(all, world, object);
  if (!world.bodies.find(object)) return all;
  add_motion(all, world.name_of(object), object);
  if (has_contact_readings(world, object))
    add_contacts(all, world.name_of(object), object, {events, step});
  return all;
}

std::vector<Reading> readings_of(std::span<const Sensor> sensors) {
  std::vector<Reading> all;
  for (const Sensor& sensor : sensors) {
    if (components_of(sensor.kind) == 1) {
      all.push_back(
          {sensor.name, "", [s = sensor](const World& w) mutable { return read_sensor(w, s).x; }});
      continue;
    }
    for (int k = 0; k < 3; ++k)
      all.push_back({sensor.name + '.' + kAxes[k], "",
                     [s = sensor, k](const World& w) mutable { return read_sensor(w, s)[k]; }});
  }
  return all;
}

}  // namespace pantin::program
