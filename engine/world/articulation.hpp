#pragma once
/// An articulation: the bodies that links and strings tie together, packed for a solver.
///
/// Built from the components when the structure changes, then kept from step to step; the memory of
/// the integrators lives here and is copied, hashed and restored with the World.
#include <array>
#include <cstdint>
#include <vector>

#include "engine/world/entity.hpp"
#include "engine/world/settings.hpp"

namespace pantin {

struct World;

inline constexpr std::int32_t kHeld = -1;  // parent: the joint point follows a place in the world
inline constexpr std::int32_t kFree = -2;  // parent: nothing

/// One number for each of many bodies, padded to whole lanes.
inline constexpr std::size_t kLanes = 4;
constexpr std::size_t padded(std::size_t count) { return (count + kLanes - 1) / kLanes * kLanes; }

/// Rows of packed numbers, `stride` apart, one column a body.
class Table {
 public:
  void resize(std::size_t rows, std::size_t stride) {
    stride_ = stride;
    numbers_.assign(rows * stride, 0.0);
  }
  Real* row(std::size_t r) { return numbers_.data() + r * stride_; }
  const Real* row(std::size_t r) const { return numbers_.data() + r * stride_; }
  std::size_t stride() const { return stride_; }
  std::size_t size() const { return numbers_.size(); }
  const std::vector<Real>& numbers() const { return numbers_; }

 private:
  std::vector<Real> numbers_;
  std::size_t stride_ = 0;
};

/// Room that may be thrown away between steps; a copy starts empty.
struct Scratch {
  std::vector<Real> numbers;
  Scratch() = default;
  Scratch(const Scratch&) {}
  Scratch(Scratch&&) = default;
  Scratch& operator=(const Scratch&) {
    numbers.clear();
    return *this;
  }
  Scratch& operator=(Scratch&&) = default;
};

/// One tree of the articulation: bodies [first, first + count), parents before children.
struct Tree {
  std::uint32_t first = 0, count = 0;
  /// What holds the root: slot of a kinematic body and an anchor in it, or a pin; none if free.
  std::uint32_t held_body = UINT32_MAX;  // slot in World::bodies
  std::uint32_t held_pin = UINT32_MAX;   // slot in World::pins
  Vec3 anchor{0};                        // in the held body's frame
  Vec3 target{0};                        // world, this step
  Vec3 target_before{0};                 // world, last step
  Vec3 spin_momentum{0};                 // free trees: angular momentum about the mass centre
};

/// A held point besides the roots: met by rows of the solve and by relaxation.
struct Hold {
  std::uint32_t column = 0;              // of the body in this articulation
  std::uint32_t tree = 0;
  Vec3 anchor{0};                        // in the body's frame
  std::uint32_t held_body = UINT32_MAX;  // as in Tree
  std::uint32_t held_pin = UINT32_MAX;
  Vec3 held_anchor{0};
  Vec3 target{0}, target_before{0};
  int priority = 0;
  Real compliance = 0;  // m/N; 0 is exact
  Vec3 load{0};         // multiplier of the last step, kg m
  Real reach = 0, dead_reach = 0;  // largest and smallest distance to the root's target
  Real residual = 0;
  bool reachable = true;
};

/// A string in packed form. A column of UINT32_MAX means a kinematic body at `slot`.
struct Cord {
  std::uint32_t string = 0;  // slot in World::strings
  std::uint32_t column_a = UINT32_MAX, column_b = UINT32_MAX;
  std::uint32_t slot_a = 0, slot_b = 0;
  Real load = 0;  // multiplier of the last step, kg m
};

struct Articulation {
  SolverSettings settings;
  std::vector<Entity> bodies;         // tree order
  std::vector<std::uint32_t> slots;   // in World::bodies, padded
  std::vector<std::int32_t> parents;  // column, kHeld or kFree
  std::vector<Tree> trees;
  std::vector<Hold> holds;
  std::vector<Cord> cords;
  Table constants;  // see Constant
  Table memory;     // see Memory
  Real size = 0;    // m, longest way through the joints; scales tolerances
  bool is_chain = false;  // every parent is the column before: the fast path

  // What the integrators remember besides the tables.
  int calm_steps = 0;
  bool fresh = true;     // no step was taken yet, or all memory was dropped
  Real last_step = 0;    // s
  Real budget = 0;       // J, what the limiter allows
  bool budget_known = false;

  // What the last step did; not part of the state.
  int rounds_used = 0;
  bool limited = false, second_order = false;

  Scratch scratch;

  std::size_t count() const { return bodies.size(); }
  std::size_t stride() const { return constants.stride(); }
};

/// Rows of Articulation::constants.
enum Constant : std::size_t {
  kMass,
  kInertia,                    // 3 principal moments
  kOwnAnchor = kInertia + 3,   // 3, joint to the parent, in this body
  kParentAnchor = kOwnAnchor + 3,  // 3, the same point in the parent
  kDrag = kParentAnchor + 3,
  kGravityScale,
  kConstantRows
};

/// Rows of Articulation::memory, for the integrators.
enum Memory : std::size_t {
  kLastSlide,                   // 3, displacement over the last step, m
  kLastTurn = kLastSlide + 3,   // 3, rotation vector of the last step, rad
  kVelocityBefore = kLastTurn + 3,      // 3, velocity at the start of the last step
  kSpinBefore = kVelocityBefore + 3,    // 3, spin at the start of the last step
  kLoad = kSpinBefore + 3,              // 3, joint multiplier of the last step, kg m
  kMemoryRows = kLoad + 3
};

/// What is wrong with the structure, by entity; empty when it can be solved.
struct StructureFault {
  Entity link;         // the link or string concerned
  const char* reason;  // one clause
};

/// Rebuilds `world.articulations` from its components, carrying the integrators' memory over by
/// body. Faulty links are left out and listed in `world.faults`.
void rebuild_articulations(World& world);

}  // namespace pantin
