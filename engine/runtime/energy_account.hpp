#pragma once
/// An energy account for each group of bodies that are joined or have touched, independent of
/// solvers.
///
///   balance = energy now - energy at the start - work done      must not grow
///
/// Work is estimated from above: of pushes and wind, of motors and drives, of conveyors and of led
/// bodies. A led body that is the only holder of a group does
///
///   work = impulse . velocity + angular impulse . angular velocity
///
/// where the impulses follow from the momentum of the group, gravity, pushes and contacts. With
/// several holders they are indeterminate and the balance is not checked. In a group without
/// dissipation the balance must not fall either, except by the work of contact forces and the
/// impacts of cables. A group without holders keeps its angular momentum.
///
/// The work of a led body has no bound: it can give any speed to a body that is wedged. But a
/// single led body throws nothing faster than twice the speed of its own contact point.
#include <algorithm>
#include <span>
#include <vector>

#include "engine/base/disjoint_sets.hpp"
#include "engine/runtime/energy_stores.hpp"
#include "engine/world/world.hpp"

namespace pantin {
struct Contact;
}

namespace pantin::detail {

/// The kinetic energy of a body, J.
Real kinetic_energy(const Body& body);

class EnergyAccount {
 public:
  /// Called before kinematic bodies move.
  void begin_substep(const World& world);
  /// Called before the solvers start; from here on only they change motions.
  void note_start(const World& world, Real h);
  /// Called after the solvers; `h` in s.
  void end_substep(const World& world, Real h);

  /// An unexplained change of a group of bodies.
  struct Change {
    enum class Kind : std::uint8_t { gain, loss, spin, flight } kind = Kind::gain;
    Entity body;      // the fastest, when it first occurred
    Real amount = 0;  // J, or kg m^2/s of angular momentum
  };
  /// Calls `tell(change)` for all changes that exceed their tolerance.
  template <class Tell>
  void each_change(const World& world, const Tell& tell) const {
    for (const std::uint32_t root : moving_) {
      const Group& g = groups_[root];
      if (g.fastest >= world.bodies.size()) continue;
      const auto body = [&] { return world.bodies.owners()[g.fastest]; };
      if (g.has_gained) tell(Change{Change::Kind::gain, body(), g.gain()});
      if (g.has_lost) tell(Change{Change::Kind::loss, body(), g.missing});
      if (g.has_turned) tell(Change{Change::Kind::spin, body(), glm::length(g.drift)});
      if (g.is_flung) tell(Change{Change::Kind::flight, body(), g.kinetic});
    }
  }
  /// Whether the balance of a body is checked.
  bool is_asked(std::uint32_t slot) const;
  /// The greatest kinetic energy so far of the group of a body, J.
  Real greatest_of(std::uint32_t slot) {
    return slot < groups_.size() ? groups_[sets_.root(slot)].greatest : 0;
  }
  /// The stores after end_substep(), with the motion of each joint coordinate.
  std::span<const EnergyStore> stores() const { return stores_; }

 private:
  /// The holder of a group, besides contacts: none, one body or pin, or several.
  static constexpr std::uint32_t kNobody = UINT32_MAX, kSeveral = UINT32_MAX - 1,
                                 kPlaces = 1u << 31;  // from here on: slots of pins
  /// Sums over the bodies of a group at the end of a substep.
  struct Moments {
    Real mass = 0;                           // kg
    Vec3 first{0}, momentum{0}, angular{0};  // kg m, kg m/s, kg m^2/s about the origin
    Vec3 force{0}, torque{0};                // known forces and torques, N, N m about the origin
    Real spins = 0;                          // kg m^2/s, sum of the bodies' own angular momenta
  };
  /// A group of bodies that are joined or have touched; stored at the slot of its first body.
  struct Group {
    std::uint32_t held_by = kNobody;
    bool is_asked = true, is_lossy = false, is_slowed = false;
    bool has_gained = false, has_lost = false, has_turned = false, is_flung = false;
    int touched = 0;  // substeps left in which contacts or closing joints may rotate it
    int jerked = 0;   // substeps left in which joints and cables may dissipate energy
    std::uint32_t fastest = kNoSlot;       // body, when a finding first occurred
    Real slack = 0;                        // J, tolerance
    Real balance = 0, least = 0;           // J; minimum so far
    Real greatest = 0;                     // J, kinetic energy
    Real exchanged = 0;                    // J, sum of the absolute work so far
    Vec3 impulse_before{0};                // N s, by the holder in the last substep
    Real change = 0;                       // J, unexplained, of this substep
    Real kinetic = 0, kinetic_before = 0;  // J, at its end and at its start
    Vec3 momentum{0}, angular{0};          // unexplained by known forces, of this substep
    Real paid = 0;                         // J, of this substep: bound on the dissipation
    Real spent = 0;                        // J, sum of `paid` so far
    Real missing = 0;                      // J, unexplained loss since the last dissipation
    Moments before, now;
    Real spin = 0, slack_spin = 0;  // kg m^2/s: greatest so far; tolerance
    Vec3 drift{0};                  // kg m^2/s, unexplained angular momentum
    bool is_pressed = false;        // a led body touched it in this substep
    Real pressed_at = 0;            // m/s, the fastest pressing contact point of late
    Real worked = 0;                // J, absolute work in this substep, without led bodies
    Real calm = 0;                  // J, kinetic energy not due to led bodies
    Real rise = 0;                  // J, total change of its energy in this substep
    Real level = 0, lowest = 0;     // J, of its energy; minimum so far
    /// The energy gain, bounded by the rise of the energy itself.
    Real gain() const { return std::min(balance - std::min(least, Real(0)), level - lowest); }
  };
  struct Start {
    Pose pose;  // of kinematic bodies: before they moved
    Vec3 velocity{0}, angular_velocity{0};
    Real energy = 0, kinetic = 0;  // J
    Vec3 spin{0};                  // kg m^2/s, about its mass centre
    Vec3 force{0}, torque{0};
  };
  /// The energies of a body.
  struct Energies {
    Real kinetic = 0, all = 0;  // J
    Vec3 spin{0};               // kg m^2/s, about the mass centre
  };
  static Energies energies_of(const World& world, const Body& body);
  /// Sums over consecutive bodies of a group, in a substep.
  struct Sums {
    Moments before, now;                                       // forces: without the weight
    Real kinetic = 0, kinetic_before = 0, rise = 0, paid = 0;  // J: see Group
    Real work = 0, works = 0;                                  // J, by forces; sum of absolute
                                                               // values
    Real weight = 0;                                           // kg, subject to gravity
    Vec3 weight_first{0};                                      // kg m, first moment of it, mean
                                                               // over the substep
    Vec3 slowed_spin{0};                                       // N m, of the drag on rotation
    bool is_slowed = false;
  };

  struct Hold {
    std::uint32_t body = 0, by = 0;
  };
  struct Way {
    Pose from, to;
    Vec3 faster{0};  // m/s, increase over the substep
  };

  void compile(const World& world);
  void hold(std::uint32_t group, std::uint32_t by);
  void attach(const World& world, std::initializer_list<Entity> bodies);
  void find_losses(const World& world);
  void list_moving(const World& world);
  bool is_moving(std::uint32_t root) const { return moving_in_[root] == substep_; }
  void note_start(const World& world, std::uint32_t slot, Real h);
  void add_bodies(const World& world, Real h);
  void add_body(const World& world, std::uint32_t slot, Real h, Sums& sums) const;
  static void add_sums(const World& world, const Sums& sums, Group& group, Real h);
  void add_contacts(const World& world, Real h);
  static bool stands(const Body& b, const Start& from);
  Real taken_by(const World& world, const Contact& contact, Real h) const;
  void add_stores(const World& world, Real h);
  Way way_of(const World& world, std::uint32_t holder) const;
  void leave_out(const World& world);
  void add_cable_blows(const World& world, Real h);
  void add_leads(const World& world, Real h);
  void join(std::uint32_t a, std::uint32_t b);
  void close(const World& world, Real h);
  void close_losses(Group& group, Real h);
  void close_flight(const World& world, Group& group, Real h) const;
  void find_fastest(const World& world, std::uint32_t group);

  std::uint64_t built_for_ = 0;
  bool begun_ = false, is_new_ = false;
  DisjointSets sets_{0};
  std::vector<Start> bodies_;
  std::vector<Group> groups_;
  std::vector<std::uint32_t> moving_;     // roots of the groups with a body that is awake
  std::vector<std::uint32_t> moving_in_;  // by root: the substep in which it was listed
  std::uint32_t substep_ = 0;
  std::uint64_t rest_version_ = 0;  // Partition::rest_version when all starts were noted
  std::vector<EnergyStore> stores_;
  std::vector<Hold> holds_;
  /// The state of a cable.
  struct CableState {
    Entity cable;
    Real length = 0;  // m, length at which it is taut
    Real rate = 0;    // m/s, separation speed of its ends
  };
  static CableState state_of(const World& world, std::uint32_t cable);
  std::vector<CableState> cables_;  // after the last substep
};

}  // namespace pantin::detail
