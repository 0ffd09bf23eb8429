#pragma once
/// An account of the energy of all that is joined or has touched, from outside the solvers.
///
///   balance = energy now - energy at the start - work done      must not grow
///
/// Work is reckoned at its most: of pushes and wind, of motors and drives, of belts, and of bodies
/// that are led. A led body that alone holds what it leads does
///
///   work = impulse . velocity + angular impulse . angular velocity
///
/// and the impulses follow from the momentum of what is led, gravity, pushes and contacts. Where
/// several hold it they do not; the balance is then not asked for. Where nothing takes energy, the
/// balance must not fall either, but for what contacts take by their forces and the speeds of their
/// places, and for blows of cables; what nobody holds keeps its angular momentum.
///
/// The work of a led body has no bound: what has no room to give way is given any speed by it. But
/// a single led body throws nothing faster than its own place twice over, as it sees it.
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

/// J, of a body's motion.
Real kinetic_energy(const Body& body);

class EnergyAccount {
 public:
  /// Before kinematic bodies move.
  void begin_substep(const World& world);
  /// Before the solvers start: from here on nobody else changes motions.
  void note_start(const World& world, Real h);
  /// After them; `h` in s.
  void end_substep(const World& world, Real h);

  /// What has changed by itself, of one group of bodies.
  struct Change {
    enum class Kind : std::uint8_t { gain, loss, spin, flight } kind = Kind::gain;
    Entity body;      // the fastest, when it first happened
    Real amount = 0;  // J, or kg m^2/s of angular momentum
  };
  /// Calls `tell(change)` for all that changed by more than it may.
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
  /// Whether the balance of a body is asked for.
  bool is_asked(std::uint32_t slot) const;
  /// J: the most kinetic energy so far of all that a body is joined to or has touched.
  Real greatest_of(std::uint32_t slot) {
    return slot < groups_.size() ? groups_[sets_.root(slot)].greatest : 0;
  }
  /// After end_substep(): how far the coordinates of joints moved.
  std::span<const EnergyStore> stores() const { return stores_; }

 private:
  /// Who holds a group besides contacts: nobody, one body or place, or several.
  static constexpr std::uint32_t kNobody = UINT32_MAX, kSeveral = UINT32_MAX - 1,
                                 kPlaces = 1u << 31;  // from here on: slots of pins
  /// Sums over the bodies of a group at the end of a substep.
  struct Moments {
    Real mass = 0;                           // kg
    Vec3 first{0}, momentum{0}, angular{0};  // kg m, kg m/s, kg m^2/s about the origin
    Vec3 force{0}, torque{0};                // known ones, N, N m about the origin
    Real spins = 0;                          // kg m^2/s, of the bodies themselves
  };
  /// Of the bodies that are joined or have touched; by the slot of its first body.
  struct Group {
    std::uint32_t held_by = kNobody;
    bool is_asked = true, is_lossy = false, is_slowed = false;
    bool has_gained = false, has_lost = false, has_turned = false, is_flung = false;
    int touched = 0;  // substeps for which something may turn it: contacts, joints that jerk
    int jerked = 0;   // likewise, for which joints and cables may take energy
    std::uint32_t fastest = kNoSlot;       // body, when the group first gained
    Real slack = 0;                        // J, that does not count
    Real balance = 0, least = 0;           // J; the least so far
    Real greatest = 0;                     // J, of the kinetic energy so far
    Real exchanged = 0;                    // J, of work so far, either way
    Vec3 impulse_before{0};                // N s, of whom it is held by
    Real change = 0;                       // J, of this substep
    Real kinetic = 0, kinetic_before = 0;  // J, at its end and at its start
    Vec3 momentum{0}, angular{0};          // that no known force explains, of this substep
    Real paid = 0;                         // J, likewise: what contacts may have taken
    Real spent = 0;                        // J, all of that so far
    Real missing = 0;                      // J, lost since something took energy, and not paid
    Moments before, now;
    Real spin = 0, slack_spin = 0;  // kg m^2/s, the greatest so far; that does not count
    Vec3 drift{0};                  // kg m^2/s, of the angular momentum that nothing explains
    bool is_pressed = false;        // by a led body, in this substep
    Real pressed_at = 0;            // m/s, the fastest place that one pressed with lately
    Real worked = 0;                // J, of this substep by what is not led, either way
    Real calm = 0;                  // J, of the kinetic energy that no led body has thrown
    Real rise = 0;                  // J, of its energy in this substep, whatever did it
    Real level = 0, lowest = 0;     // J, of its energy; the least so far
    /// No more than the energy that is there to be seen.
    Real gain() const { return std::min(balance - std::min(least, Real(0)), level - lowest); }
  };
  struct Start {
    Pose pose;  // of led bodies before they were led
    Vec3 velocity{0}, angular_velocity{0};
    Real energy = 0, kinetic = 0;  // J
    Vec3 spin{0};                  // kg m^2/s, about its mass centre
    Vec3 force{0}, torque{0};
  };
  /// Of a body.
  struct Energies {
    Real kinetic = 0, all = 0;  // J
    Vec3 spin{0};               // kg m^2/s, about the mass centre
  };
  static Energies energies_of(const World& world, const Body& body);
  /// Of bodies of a group, in a substep.
  struct Sums {
    Moments before, now;                                       // forces: without the weight
    Real kinetic = 0, kinetic_before = 0, rise = 0, paid = 0;  // J: see Group
    Real work = 0, works = 0;                                  // J, by forces; of their sizes
    Real weight = 0;                                           // kg, that gravity acts on
    Vec3 weight_first{0};                                      // kg m, of that on the way
    Vec3 slowed_spin{0};                                       // N m, by drag
    bool is_slowed = false;
  };

  struct Hold {
    std::uint32_t body = 0, by = 0;
  };
  struct Way {
    Pose from, to;
    Vec3 faster{0};  // m/s, at the end than at the start
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
  std::vector<std::uint32_t> moving_;     // roots of the groups that are not wholly asleep
  std::vector<std::uint32_t> moving_in_;  // by root: the substep in which it was listed
  std::uint32_t substep_ = 0;
  std::uint64_t rest_version_ = 0;  // Partition::rest_version when all starts were noted
  std::vector<EnergyStore> stores_;
  std::vector<Hold> holds_;
  /// How a cable was.
  struct CableState {
    Real length = 0;  // m, that it may have
    Real rate = 0;    // m/s, at which its ends part
  };
  static CableState state_of(const World& world, std::uint32_t cable);
  std::vector<CableState> cables_;  // after the last substep
};

}  // namespace pantin::detail
