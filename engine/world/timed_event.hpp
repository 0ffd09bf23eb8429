#pragma once
/// Timed events: what is done to a World while it runs, at one moment or over a while.
#include <cstdint>
#include <string_view>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/joints/parameters.hpp"
#include "engine/world/entity.hpp"
#include "engine/world/settings.hpp"
#include "engine/world/store.hpp"

namespace pantin {

struct World;

enum class TimedEventKind : std::uint8_t {
  push,     // `force` and `torque` act on a body
  impulse,  // `impulse` and `angular_impulse` act on a body at one moment
  wind,     // the air moves with `velocity`: dynamic bodies are taken along by their drag
  pull,     // a hand takes a point of a body, leads it to `target` and lets go
  cut,      // a joint, a cable, a pin or a gear is destroyed
  motor,    // the motor of a joint gets other settings
  drive,    // a joint drive gets another stiffness, damping and greatest torque
  winch,    // a cable gets another length
  gravity,  // the World gets another gravity
  solver    // all islands get another solver
};
constexpr TimedEventKind last_of(TimedEventKind) { return TimedEventKind::solver; }

/// One event: `world.add(TimedEvent{...})`. The step makes it happen, and the World keeps how far
/// it has come: a copy or a saved World goes on with the same bits. `world.destroy(event)` calls it
/// off.
///
/// What lasts acts from `from` to `to`, a part of a step in proportion, so that its impulse does
/// not depend on the step. What happens at one moment does so at the boundary of substeps nearest
/// to `from`; with `over` the change takes that long: a hand and a winch start and stop softly,
/// numbers change evenly. Of several at one boundary the earlier comes first, of equals the one
/// that was added first.
struct TimedEvent {
  TimedEventKind kind = TimedEventKind::push;
  Entity on = {};                   // the body, joint, cable, pin or gear
  std::vector<Entity> bodies = {};  // wind: on these; none: on all
  Real from = 0;                    // s
  Real to = 1e300;                  // s; push, wind, pull
  Real every = 0;                   // s; push, impulse, wind: starts again so often; 0: once
  Real over = 0;                    // s; pull, motor, drive, winch, gravity: how long it takes
  Vec3 anchor{0};           // push, impulse, pull: the point, in the body's mass-centre frame
  Vec3 force{0};            // N, world axes
  Vec3 torque{0};           // N m, world axes
  Vec3 impulse{0};          // N s, world axes
  Vec3 angular_impulse{0};  // N m s, world axes
  Vec3 velocity{0};         // m/s, of the wind
  Vec3 gusts{0};            // m/s, the most by which gusts change it along each axis
  Real gust_time = 1;       // s, from one gust to the next
  std::uint64_t seed = 1;   // of the gusts; with the same seed the same ones, at any step
  Real drag = -1;           // 1/s; wind: by this rate beside the own drag; below 0: by the own one
  Vec3 target{0};           // m; pull
  Real stiffness = 0;       // N/m of a hand that gives way, 0: exact; N m/rad of a drive
  Real damping = 0;         // N m s/rad, of a drive
  Real max_torque = 1e300;  // N m, of a drive
  JointMotor motor = {};    // along the joint's angle, or its travel if it has no angle
  Real length = 1;          // m, of the cable
  Vec3 gravity{0, -9.81, 0};  // m/s^2
  Solver solver = Solver::articulated;

  static constexpr std::string_view name = "timed event";  // in saved Worlds

  /// How far it has come.
  struct Progress {
    std::uint64_t fired = 0;  // how often it began
    bool done = false;
    Vec3 start{0};    // what was there before: a place, a gravity; the numbers of a motor or drive
    Entity pin = {};  // of the hand

    static void fields(auto& self, auto&& field) {
      field("fired", self.fired);
      field("done", self.done);
      field("start", self.start);
      field("pin", self.pin);
    }
  } progress = {};

  static void fields(auto& self, auto&& field) {
    field("kind", self.kind);
    field("on", self.on);
    field("bodies", self.bodies);
    field("from", self.from);
    field("to", self.to);
    field("every", self.every);
    field("over", self.over);
    field("anchor", self.anchor);
    field("force", self.force);
    field("torque", self.torque);
    field("impulse", self.impulse);
    field("angular_impulse", self.angular_impulse);
    field("velocity", self.velocity);
    field("gusts", self.gusts);
    field("gust_time", self.gust_time);
    field("seed", self.seed);
    field("drag", self.drag);
    field("target", self.target);
    field("stiffness", self.stiffness);
    field("damping", self.damping);
    field("max_torque", self.max_torque);
    field("motor", self.motor);
    field("length", self.length);
    field("gravity", self.gravity);
    field("solver", self.solver);
    field("progress", self.progress);
  }
  /// Null, or what no step can use, for a saved World.
  const char* restored() const;
};

namespace detail {

/// The words of scene files, by kind.
inline constexpr std::string_view kTimedEventNames[] = {
    "push", "impulse", "wind", "pull", "cut", "motor", "drive", "winch", "gravity", "solver"};

/// Whether it acts from `from` to `to`; otherwise at one moment, or over a while.
constexpr bool lasts(TimedEventKind kind) {
  return kind == TimedEventKind::push || kind == TimedEventKind::wind;
}

/// The shortest time after which an event starts again, and from gust to gust, s.
inline constexpr Real kShortestRepeat = 1e-3;

/// Of two members that contradict each other or a number that is none: the member, what was found,
/// what was expected. Only what can be told without a World.
struct TimedEventFault {
  const char *member, *found, *expected;
};
const TimedEventFault* fault_of(const TimedEvent& event);

/// All events of a World, in the order they were added.
Store<TimedEvent>& events_of(World& world);
const Store<TimedEvent>* events_of(const World& world);

/// Adds an event that was checked; steps it causes allocate nothing, but for those that change the
/// structure.
Entity add_event(World& world, const TimedEvent& event);

/// Mean over a time of noise that goes smoothly from one random number to the next, each within
/// [-1, 1]; they follow from `seed`, `axis` and their number.
struct Noise {
  std::uint64_t seed, axis;
  Real period;  // s
};
Real mean_of(const Noise& noise, Real from, Real to);

/// How much of the time from `from` to `to` (s) a push or wind acts.
Real active_time(const TimedEvent& event, Real from, Real to);

}  // namespace detail
}  // namespace pantin
