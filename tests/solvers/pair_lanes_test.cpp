// Contact points of pairs of bodies without joints, solved four pairs side by side.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <vector>

#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/kernels.hpp"
#include "tests/base/random.hpp"
#include "tests/solvers/standing.hpp"

using namespace pantin;
using namespace pantin::test;
using namespace pantin::detail::articulated;

namespace {

struct TestBody {
  std::array<double, 9> state{};  // velocity, spin, angular momentum
  double per_mass = 0;
  Mat3 response{0};
  Vec3 velocity() const { return {state[0], state[1], state[2]}; }
  Vec3 spin() const { return {state[3], state[4], state[5]}; }
  void push(Vec3 impulse, Vec3 arm) {
    const Vec3 moment = glm::cross(arm, impulse), turn = response * moment;
    for (int k = 0; k < 3; ++k) {
      const auto n = static_cast<std::size_t>(k);
      state[n] += per_mass * impulse[k], state[3 + n] += turn[k];
      if (per_mass > 0) state[6 + n] += moment[k];
    }
  }
};

struct TestPoint {
  Vec3 axes[3], arm_a, arm_b, impulse{0};
  double friction = 0, speed = 0, parted = 0, kept = 1, by_mass = 1, surface[2] = {};
};

struct TestPair {
  TestBody a, b;
  std::vector<TestPoint> points;
};

TestBody random_body(Random& dice, bool moves) {
  TestBody b;
  for (double& x : b.state) x = dice.between(-2, 2);
  if (!moves) return b;
  b.per_mass = std::pow(10.0, dice.between(-1, 1));
  Mat3 root;
  for (int k = 0; k < 3; ++k) root[k] = dice.in_cube(1);
  b.response = 20 * b.per_mass * (root * glm::transpose(root) + Mat3(0.3));
  return b;
}

TestPair random_pair(Random& dice, std::size_t points) {
  TestPair p{random_body(dice, true), random_body(dice, points != 3), {}};
  for (std::size_t i = 0; i < points; ++i) {
    TestPoint k;
    k.axes[0] = glm::normalize(Vec3(0, 1, 0) + 0.3 * dice.in_cube(1));
    k.axes[1] = glm::normalize(glm::cross(k.axes[0], Vec3(1, 0, 0)));
    k.axes[2] = glm::cross(k.axes[0], k.axes[1]);
    k.arm_a = dice.in_cube(0.2), k.arm_b = dice.in_cube(0.2);
    k.friction = dice.between(0, 1), k.speed = dice.between(-0.1, 0.1), k.parted = k.speed;
    k.kept = dice.between(0.8, 1), k.by_mass = dice.between(0.5, 1);
    k.surface[0] = dice.between(-1, 1), k.surface[1] = dice.between(-1, 1);
    if (i % 2 == 0) k.impulse = {dice.between(0, 1), 0, 0};
    p.points.push_back(k);
  }
  return p;
}

/// Change of the relative velocity at a point by an impulse there.
Vec3 response(const TestPair& p, const TestPoint& k, Vec3 impulse) {
  const auto of = [&](const TestBody& b, Vec3 arm) {
    return b.per_mass * impulse + glm::cross(b.response * glm::cross(arm, impulse), arm);
  };
  return of(p.a, k.arm_a) + of(p.b, k.arm_b);
}

/// One projected Gauss-Seidel step at a point, from the definition.
void solve(TestPair& p, TestPoint& k) {
  const Vec3 u = p.a.velocity() + glm::cross(p.a.spin(), k.arm_a) - p.b.velocity() -
                 glm::cross(p.b.spin(), k.arm_b);
  const Vec3 by_normal = response(p, k, k.axes[0]), by_first = response(p, k, k.axes[1]),
             by_second = response(p, k, k.axes[2]);
  const double least = k.impulse.x > 0 ? k.speed : k.parted;
  const double gain = k.by_mass / glm::dot(k.axes[0], by_normal);
  const double normal =
      std::max(0.0, k.kept * k.impulse.x + gain * (least - glm::dot(k.axes[0], u)));
  const double k1 = glm::dot(k.axes[1], by_first), k2 = glm::dot(k.axes[2], by_second),
               k12 = glm::dot(k.axes[1], by_second);
  const double aside = 0.5 * (k1 + k2) + std::sqrt(0.25 * (k1 - k2) * (k1 - k2) + k12 * k12);
  const Vec3 later = u + (normal - k.impulse.x) * by_normal;
  double first = k.impulse.y - (glm::dot(k.axes[1], later) + k.surface[0]) / aside;
  double second = k.impulse.z - (glm::dot(k.axes[2], later) + k.surface[1]) / aside;
  const double held = std::hypot(first, second), most = k.friction * normal;
  if (held > most) first *= most / held, second *= most / held;
  const Vec3 now(normal, first, second), change = now - k.impulse;
  k.impulse = now;
  const Vec3 impulse = change.x * k.axes[0] + change.y * k.axes[1] + change.z * k.axes[2];
  p.a.push(impulse, k.arm_a), p.b.push(-impulse, k.arm_b);
}

/// Puts pairs into lanes and solves them.
class Batch {
 public:
  Batch(std::vector<TestPair>& pairs, int iterations) : pairs_(pairs) {
    for (const TestPair& p : pairs) lanes_.points = std::max(lanes_.points, p.points.size());
    numbers_.assign(kPairLanes * (kPairRows + kPointRows * lanes_.points), 0.0);
    lanes_.pairs = pairs.size(), lanes_.tolerance = 0, lanes_.table = numbers_.data();
    for (std::size_t l = 0; l < kPairLanes; ++l) {
      TestPair& p = pairs[l < pairs.size() ? l : 0];
      lanes_.a[l] = p.a.state.data(), lanes_.b[l] = p.b.state.data();
      if (l < pairs.size()) fill(l, p, iterations);
    }
  }
  void solve(const Kernels& kernels) {
    kernels.prepare_pairs(lanes_);
    kernels.solve_pairs(lanes_);
    for (std::size_t l = 0; l < pairs_.size(); ++l)
      for (std::size_t i = 0; i < pairs_[l].points.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k)
          pairs_[l].points[i].impulse[static_cast<int>(k)] = *at(i, kPointImpulse + k, l);
  }

 private:
  double* at(std::size_t point, std::size_t row, std::size_t lane) {
    return &numbers_[kPairLanes * (kPairRows + kPointRows * point + row) + lane];
  }
  void fill(std::size_t l, const TestPair& p, int iterations) {
    numbers_[kPairLanes * kPairIterations + l] = iterations;
    for (const auto& [body, row] :
         {std::pair(&p.a, std::size_t(kPairOfA)), std::pair(&p.b, std::size_t(kPairOfB))}) {
      const Mat3& r = body->response;
      const double values[] = {body->per_mass, r[0][0], r[1][0], r[2][0],
                               r[1][1],        r[2][1], r[2][2]};
      for (std::size_t n = 0; n < 7; ++n) numbers_[kPairLanes * (row + n) + l] = values[n];
    }
    for (std::size_t i = 0; i < p.points.size(); ++i) {
      const TestPoint& k = p.points[i];
      const auto set = [&](std::size_t row, Vec3 v) {
        for (std::size_t n = 0; n < 3; ++n) *at(i, row + n, l) = v[static_cast<int>(n)];
      };
      for (std::size_t n = 0; n < 3; ++n) set(kPointAxes + 3 * n, k.axes[n]);
      set(kPointArmA, k.arm_a), set(kPointArmB, k.arm_b), set(kPointImpulse, k.impulse);
      *at(i, kPointSurface, l) = k.surface[0], *at(i, kPointSurface + 1, l) = k.surface[1];
      *at(i, kPointFriction, l) = k.friction, *at(i, kPointSpeed, l) = k.speed;
      *at(i, kPointParted, l) = k.parted, *at(i, kPointKept, l) = k.kept;
      *at(i, kPointByMass, l) = k.by_mass;
    }
  }
  std::vector<TestPair>& pairs_;
  std::vector<double> numbers_;
  PairLanes lanes_{};
};

std::vector<double> numbers_of(const TestPair& p) {
  std::vector<double> all(p.a.state.begin(), p.a.state.end());
  all.insert(all.end(), p.b.state.begin(), p.b.state.end());
  for (const TestPoint& k : p.points)
    all.insert(all.end(), {k.impulse.x, k.impulse.y, k.impulse.z});
  return all;
}

}  // namespace

TEST_CASE("pairs in lanes are solved as each pair alone, to the bit, by all kernels") {
  Random dice(7);
  for (int trial = 0; trial < 40; ++trial) {
    std::vector<TestPair> start;
    for (const std::size_t points : {1, 3, 4, 8}) start.push_back(random_pair(dice, points));
    start.resize(static_cast<std::size_t>(1 + trial % 4));
    const int iterations = 1 + trial % 8;
    std::vector<TestPair> expected = start, first;
    for (TestPair& p : expected)
      for (int n = 0; n < iterations; ++n)
        for (std::size_t i = 0; i < p.points.size(); ++i)
          solve(p, p.points[n % 2 ? p.points.size() - 1 - i : i]);
    for (const Kernels* const* k = all_kernels(); *k; ++k) {
      INFO("kernels " << (*k)->name << ", trial " << trial);
      std::vector<TestPair> together = start;
      Batch(together, iterations).solve(**k);
      for (std::size_t l = 0; l < start.size(); ++l) {
        const std::vector<double> now = numbers_of(together[l]), right = numbers_of(expected[l]);
        for (std::size_t n = 0; n < now.size(); ++n)
          REQUIRE(now[n] == Approx(right[n]).epsilon(1e-9).margin(1e-10));
        std::vector<TestPair> alone{start[l]};
        Batch(alone, iterations).solve(**k);
        REQUIRE(numbers_of(alone[0]) == now);
        if (!first.empty()) REQUIRE(numbers_of(first[l]) == now);
      }
      first = together;
    }
  }
}

TEST_CASE("no body that moves is in two pairs of a colour") {
  Standing heap;
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 9; ++k)
      heap.add({0.22 * (k % 3) + 0.03 * i, 0.11 + 0.21 * i, 0.22 * (k / 3)}, Vec3(0.1), 500,
               from_rotation_vector({0.05 * k, 0.3 * i, 0}));
  Simulation sim = Simulation::copy_of(heap.world, {});
  std::size_t most = 0, colours = 0;
  for (int i = 0; i < 60; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    const GroupScratch& r = sim.world.memory.of<Islands>().groups;
    for (const GroupScratch::Range& range : r.groups) {
      std::set<std::pair<std::uint32_t, std::uint32_t>> taken;  // colour and body
      most = std::max(most, range.laned);
      for (std::size_t n = 0; n < range.laned; ++n) {
        const LanedPair& laned = r.laned[range.first_laned + n];
        const GroupPair& pair = r.pairs[range.first_pair + laned.pair];
        const GroupContact& c = r.contacts[range.first_contact + pair.first];
        CHECK(pair.in_lanes);
        for (const std::uint32_t body : {c.a, c.b})
          if (r.bodies[range.first_body + body].per_mass > 0)
            CHECK(taken.insert({laned.colour, body}).second);
        colours = std::max<std::size_t>(colours, laned.colour + 1);
      }
    }
  }
  CHECK(most > 30);
  CHECK(colours > 2);
}

TEST_CASE("threads share the pairs of a colour, with the bits of one thread") {
  Standing field;
  for (int i = 0; i < 14; ++i)
    for (int k = 0; k < 14; ++k)
      field.add({0.19 * i, 0.12 + 0.03 * (i % 3), 0.19 * k}, {0.1, 0.1, 0.09}, 500,
                from_rotation_vector({0.02 * k, 0.1 * i, 0}));
  StepSettings two;
  two.threads = 2;
  Simulation one = Simulation::copy_of(field.world, {}),
             other = Simulation::copy_of(field.world, two);
  std::size_t most = 0;
  for (int i = 0; i < 40; ++i) {
    REQUIRE(one.step().status == Status::ok);
    other.step();
    REQUIRE(state_hash(one.world) == state_hash(other.world));
    const GroupScratch& r = one.world.memory.of<Islands>().groups;
    std::size_t first = 0;  // batches of the first colour
    for (const PairBatch& b : r.batches) first += b.count > 0 && b.colour == 0;
    most = std::max(most, first);
  }
  CHECK(most >= 16);
}
