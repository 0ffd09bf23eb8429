#pragma once
/// Timed events of any kind in the list, with members that bytes make: see random_program.hpp.
#include <optional>
#include <pantin/events.hpp>
#include <string_view>
#include <vector>

namespace pantin::test::random_program {

/// Fills the members of an event, by their names and types.
template <class Bytes, class Thing>
struct EventFiller {
  Bytes& bytes;
  const Thing& thing;  // any entity, or one that is none

  void operator()(std::string_view, Entity& entity) const { entity = thing(); }
  void operator()(std::string_view, std::vector<Entity>& all) const {
    if (bytes.chance(3)) all = {thing(), thing()};
  }
  void operator()(std::string_view name, Real& number) const {
    if (name == "from" || name == "at")
      number = bytes.chance(8) ? bytes.number() : bytes.positive() / 4;
    else if (bytes.chance(name == "length" ? 1 : 4))
      number = bytes.number();
  }
  void operator()(std::string_view, Vec3& v) const {
    v = bytes.chance(4) ? bytes.numbers() : bytes.place();
  }
  void operator()(std::string_view, Solver& solver) const {
    solver = static_cast<Solver>(bytes.pick(7));
  }
  void operator()(std::string_view, std::uint64_t& seed) const { seed = bytes.pick(100); }
  void operator()(std::string_view, std::optional<DriveMotion>& motion) const {
    if (!bytes.chance(3)) return;
    motion.emplace().speed = bytes.number();
    motion->at_start = bytes.chance(2), motion->offset = bytes.number();
    if (bytes.chance(3)) motion->knots = {{0, bytes.number()}, {bytes.positive(), bytes.number()}};
  }
  void operator()(std::string_view, JointMotor& motor) const {
    motor.kind = static_cast<MotorKind>(bytes.pick(3));
    motor.target = bytes.number(), motor.gain = bytes.number();
  }
};

template <class Bytes, class Thing, class Add>
void add_random_event(Bytes& bytes, const Thing& thing, const Add& add) {
  const auto one_of = [&]<class... Kinds>(const std::variant<Kinds...>*) {
    const unsigned picked = bytes.pick(sizeof...(Kinds));
    unsigned kind = 0;
    const auto add_if = [&](auto event) {
      if (kind++ != picked) return;
      event.fields(event, EventFiller<Bytes, Thing>{bytes, thing});
      add(event);
    };
    (add_if(Kinds{}), ...);
  };
  one_of(static_cast<const detail::EventKinds*>(nullptr));
}

}  // namespace pantin::test::random_program
