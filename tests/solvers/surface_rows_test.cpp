// Rows of surfaces that touch: against differences, and the forms of the first paper on them.
#include <catch2/catch.hpp>
#include <random>

#include "engine/solvers/lagrangian/surface_differences.hpp"
#include "engine/world/ties.hpp"
#include "tests/nurbs/data.hpp"
#include "tests/solvers/surfaces.hpp"

using namespace pantin;
using namespace pantin::test;
namespace lag = pantin::detail::lagrangian;

namespace {

/// Two bodies near one another, with the joint of their surfaces, in motion; the one island of the
/// World stands ready.
struct Meeting3 {
  World world;
  Entity a, b, contact;
  BodyState from[2];
};

BodyState moved(const BodyState& s, Real t) {
  BodyState to = s;
  to.position += t * s.velocity;
  to.rotation = glm::normalize(from_rotation_vector(t * s.angular_velocity) * s.rotation);
  return to;
}

/// The kinds of pairs, and how far a stands from b along z.
struct Skins {
  SkinPtr a, b;
  Real apart;
};
const Skins& skins(int i) {
  static const Skins kPairs[] = {
      {ball_skin({0.3, 0.2, 0.25}), ball_skin({0.5, 0.3, 0.4}), 0.6},
      {ball_skin({0.3, 0.3, 0.2}), flat_skin(4, {0, 0, 1}), 0.15},
      {skin_of(nurbs::torus({}, 0.2, 0.1)), ball_skin({0.6, 0.5, 0.4}), 0.52},
      {flat_skin(4, {0, 0, -1}), ball_skin({0.5, 0.3, 0.4}), 0.4}};
  return kPairs[i];
}

Meeting3 meeting(const Skins& skins, std::mt19937& random) {
  std::uniform_real_distribution<Real> some(-1, 1);
  const auto vector = [&](Real size) {
    return size * Vec3(some(random), some(random), some(random));
  };
  Meeting3 m{exact_world(Integrator::rk4), {}, {}, {}, {}};
  Body a = solid(1, {0.1, 0.2, 0.25}, {{}, from_rotation_vector(vector(0.6))});
  Body b = solid(2, {0.2, 0.3, 0.4}, {{0, 0, 0}, from_rotation_vector(vector(0.6))});
  a.pose.position = Vec3(0.02, 0.05, skins.apart);
  for (Body* body : {&a, &b}) body->velocity = vector(1), body->angular_velocity = vector(1);
  m.a = m.world.add_body(a), m.b = m.world.add_body(b);
  m.contact = touch(m.world, {m.a, skins.a, m.b, skins.b}, SurfaceMotion::rolling_without_spin);
  // Surfaces stand askew in their bodies.
  SurfaceContact& c = m.world.surface_contacts[m.contact];
  c.on_a.pose = {vector(0.05), from_rotation_vector(vector(0.3))};
  c.on_b.pose = {vector(0.05), from_rotation_vector(vector(0.3))};
  int i = 0;
  for (const Entity e : {m.a, m.b}) m.from[i++] = placed_of(m.world.bodies[e]);
  return m;
}

/// Rows at a time of the free motion: c, the rates J V, and gamma.
struct RowsAt {
  std::array<Real, 4> c{}, rate{}, gamma{};
  std::array<Vec3, 16> j{};
};
RowsAt rows_at(Meeting3& m, Real t, std::size_t rows = 4) {
  lag::Island& island = ready(m.world);
  if (!island.touches[0].known) lag::find_touches(m.world, island, 0.01);
  REQUIRE(island.touches[0].known);
  for (std::size_t i = 0; i < 2; ++i) {
    const BodyState s = moved(m.from[i], t);
    island.scratch.state.x[i] = s.position, island.scratch.state.q[i] = s.rotation;
    island.scratch.state.v[i] = s.velocity, island.scratch.state.w[i] = s.angular_velocity;
  }
  lag::update_kinematics(island), lag::write_all_rows(m.world, island, {true, true});
  RowsAt out;
  REQUIRE(island.scratch.lost_touch == UINT32_MAX);
  for (std::size_t r = 0, block = 0; r < rows; ++r) {
    block = r == 0 ? 0 : 1;
    const lag::Block& b = island.blocks[block];
    const std::size_t row = r == 0 ? 0 : r - 1;
    out.c[r] = island.scratch.c[b.first_row + row];
    out.gamma[r] = island.scratch.gamma[b.first_row + row];
    out.rate[r] = lag::rate_of(island, b, row);
    for (std::size_t k = 0; k < 4; ++k) out.j[4 * r + k] = lag::jacobian_of(island, b)[4 * row + k];
  }
  return out;
}

/// The derivative by time of what `value` gives, extrapolated.
template <class Value>
Real derivative(Value&& value, Real h) {
  const auto central = [&](Real step) { return (value(step) - value(-step)) / (2 * step); };
  return (4 * central(h / 2) - central(h)) / 3;
}

}  // namespace

TEST_CASE("surfaces: rows are the derivatives of the gap, and gamma is that of the rows") {
  std::mt19937 random(5);
  for (int n = 0; n < 40; ++n) {
    Meeting3 m = meeting(skins(n % 4), random);
    const RowsAt now = rows_at(m, 0);
    INFO(n << ", gap " << now.c[0]);
    const Real gap_rate = derivative([&](Real t) { return rows_at(m, t).c[0]; }, 5e-5);
    CHECK(std::abs(gap_rate - now.rate[0]) <= 1e-9);
    for (std::size_t r = 0; r < 4; ++r) {
      const Real change = derivative([&](Real t) { return rows_at(m, t).rate[r]; }, 5e-5);
      INFO("row " << r);
      CHECK(std::abs(change + now.gamma[r]) <= 1e-9 * std::max(Real(1), std::abs(now.gamma[r])));
    }
    for (std::size_t r = 1; r < 4; ++r) CHECK(now.c[r] == 0);
  }
}

namespace {

using WirePtr = std::shared_ptr<const nurbs::Wire>;
WirePtr ellipse_of(Real a, Real b) {
  return std::make_shared<const nurbs::Wire>(nurbs::ellipse({}, a, b));
}

/// The rows of curves against differences; so many of them.
void check_rows_of_curves(Meeting3& m, std::size_t blocks) {
  const RowsAt now = rows_at(m, 0, blocks);
  CHECK(std::abs(derivative([&](Real t) { return rows_at(m, t, blocks).c[0]; }, 5e-5) -
                 now.rate[0]) <= 1e-9);
  for (std::size_t r = 0; r < blocks; ++r) {
    INFO("row " << r);
    const Real change = derivative([&](Real t) { return rows_at(m, t, blocks).rate[r]; }, 5e-5);
    CHECK(std::abs(change + now.gamma[r]) <= 1e-9 * std::max(Real(1), std::abs(now.gamma[r])));
  }
}

}  // namespace

TEST_CASE(
    "surfaces: curves of the plane, and a curve over a face, have rows that are derivatives") {
  std::mt19937 random(9);
  std::uniform_real_distribution<Real> some(-1, 1);
  for (int n = 0; n < 10; ++n) {
    Meeting3 m{exact_world(Integrator::rk4), {}, {}, {}, {}};
    const bool flat = n % 2 == 0;
    const auto vector = [&](Real size) {
      return flat ? size * Vec3(some(random), some(random), 0)
                  : size * Vec3(some(random), some(random), some(random));
    };
    const auto turn = [&](Real size) {
      return flat ? Vec3(0, 0, size * some(random)) : vector(size);
    };
    Body a = solid(1, {0.1, 0.2, 0.25}, {{0.05, 0.5, 0}, from_rotation_vector(turn(0.3))});
    Body b = solid(2, {0.2, 0.3, 0.4}, {{0, 0, 0}, from_rotation_vector(turn(0.3))});
    for (Body* body : {&a, &b}) body->velocity = vector(1), body->angular_velocity = turn(1);
    m.a = m.world.add_body(a), m.b = m.world.add_body(b);
    SurfaceContact c;
    c.a = m.a, c.b = m.b, c.motion = SurfaceMotion::rolling;
    c.on_a.curve = ellipse_of(0.3, 0.2);
    c.at = {{0, 0.75, 0}, {0, 0.25, 0}}, c.known = true;
    if (flat)
      c.on_b.curve = ellipse_of(0.4, 0.25);
    else
      c.on_b.skin = ball_skin({0.4, 0.25, 0.3}), c.at.b = {2, 0, 0};
    m.contact = add_surface_contact(m.world, c);
    int i = 0;
    for (const Entity e : {m.a, m.b}) m.from[i++] = placed_of(m.world.bodies[e]);
    INFO(n);
    check_rows_of_curves(m, flat ? 2 : 3);
  }
}

TEST_CASE("surfaces: two bodies that move as one have no rates, and pull with equal forces") {
  std::mt19937 random(7);
  for (int n = 0; n < 20; ++n) {
    Meeting3 m = meeting(skins(n % 4), random);
    RowsAt now = rows_at(m, 0);
    m.from[0].position -= now.c[0] * now.j[0];  // until they touch
    m.from[0].angular_velocity = m.from[1].angular_velocity;
    m.from[0].velocity = m.from[1].velocity + glm::cross(m.from[1].angular_velocity,
                                                         m.from[0].position - m.from[1].position);
    now = rows_at(m, 0);
    for (std::size_t r = 0; r < 4; ++r) {
      CHECK(std::abs(now.rate[r]) <= 1e-14);
      CHECK(now.j[4 * r] == -now.j[4 * r + 2]);
      // The moments differ by the gap alone.
      const Vec3 moment = now.j[4 * r + 1] + now.j[4 * r + 3] +
                          glm::cross(m.from[0].position, now.j[4 * r]) +
                          glm::cross(m.from[1].position, now.j[4 * r + 2]);
      CHECK(glm::length(moment) <= std::abs(now.c[0]) + 1e-14);
    }
  }
}

namespace {

/// The forms of the paper, of closest points tracked anew at every pose: C_p = d.d, C_tan =
/// (d.B_u, d.B_v), C_roll = -A_u.v, -A_v.v with v the velocity of the two points apart. [Nelson &
/// Cohen, Eqns 3-13]
struct PaperForms {
  Real gap2 = 0;
  std::array<Real, 2> tangential{}, rolling{};
};
PaperForms paper_forms(Meeting3& m, Real t) {
  rows_at(m, t);
  const lag::Island& island = lag::islands_of(m.world)[0];
  const SurfaceContact& c = m.world.surface_contacts[m.contact];
  const nurbs::PlacePair& at = island.scratch.state.touches[0].at;
  const BodyState a = moved(m.from[0], t), b = moved(m.from[1], t);
  const Pose pa = compose({a.position, a.rotation}, c.on_a.pose);
  const Pose pb = compose({b.position, b.rotation}, c.on_b.pose);
  const nurbs::Jet p = c.on_a.skin->face(at.a.face).at(at.a.u, at.a.v);
  const nurbs::Jet q = c.on_b.skin->face(at.b.face).at(at.b.u, at.b.v);
  const Vec3 on_a = to_world(pa, p.s), on_b = to_world(pb, q.s), d = on_a - on_b;
  const Vec3 v = a.velocity + glm::cross(a.angular_velocity, on_a - a.position) - b.velocity -
                 glm::cross(b.angular_velocity, on_b - b.position);
  return {glm::dot(d, d),
          {glm::dot(d, pb.rotation * q.u), glm::dot(d, pb.rotation * q.v)},
          {-glm::dot(pa.rotation * p.u, v), -glm::dot(pa.rotation * p.v, v)}};
}

}  // namespace

TEST_CASE("surfaces: the paper's forms agree where they say anything") {
  std::mt19937 random(3);
  for (int n = 0; n < 20; ++n) {
    Meeting3 m = meeting(skins(n % 4), random);
    const RowsAt now = rows_at(m, 0);
    const PaperForms paper = paper_forms(m, 0);
    INFO(n);
    CHECK(paper.gap2 == Approx(now.c[0] * now.c[0]).epsilon(1e-9));
    // At closest points the tangential form is zero, whatever the bodies do.
    CHECK(std::abs(paper.tangential[0]) + std::abs(paper.tangential[1]) <= 1e-11);
    // C_p by differences: twice the gap times its rate, which is nothing where they touch.
    const Real rate = derivative([&](Real t) { return paper_forms(m, t).gap2; }, 5e-5);
    CHECK(rate == Approx(2 * now.c[0] * now.rate[0]).margin(1e-8));
    // C_roll is the slip along the tangents of a: zero where the rows of rolling are.
    rows_at(m, 0);
    const lag::Island& island = lag::islands_of(m.world)[0];
    const lag::SurfaceFound& found = island.scratch.touching[0];
    const Vec3 slip = now.rate[1] * found.tangent[0] + now.rate[2] * found.tangent[1];
    const SurfaceContact& c = m.world.surface_contacts[m.contact];
    const nurbs::PlacePair& at = island.scratch.state.touches[0].at;
    const Quat turn = m.from[0].rotation * c.on_a.pose.rotation;
    const nurbs::Jet p = c.on_a.skin->face(at.a.face).at(at.a.u, at.a.v);
    CHECK(paper.rolling[0] == Approx(-glm::dot(turn * p.u, slip)).margin(1e-12));
    CHECK(paper.rolling[1] == Approx(-glm::dot(turn * p.v, slip)).margin(1e-12));
  }
}

TEST_CASE("surfaces: the paper's C_roll, differenced once, gives the gammas of the rolling rows") {
  std::mt19937 random(4);
  for (int n = 0; n < 20; ++n) {
    Meeting3 m = meeting(skins(n % 4), random);
    // Without slip: b's motion, and a turn about the place on a.
    RowsAt now = rows_at(m, 0);
    const Vec3 arm = lag::islands_of(m.world)[0].scratch.touching[0].arm[0];
    m.from[0].position -= now.c[0] * now.j[0];
    const Vec3 place = m.from[0].position + arm;
    m.from[0].velocity = m.from[1].velocity +
                         glm::cross(m.from[1].angular_velocity, place - m.from[1].position) -
                         glm::cross(m.from[0].angular_velocity, arm);
    now = rows_at(m, 0);
    INFO(n);
    REQUIRE(std::abs(now.rate[0]) + std::abs(now.rate[1]) + std::abs(now.rate[2]) <= 1e-12);
    const lag::Island& island = lag::islands_of(m.world)[0];
    const lag::SurfaceFound& found = island.scratch.touching[0];
    const Vec3 slip_rate = -(now.gamma[1] * found.tangent[0] + now.gamma[2] * found.tangent[1]);
    const SurfaceContact& c = m.world.surface_contacts[m.contact];
    const nurbs::PlacePair at = island.scratch.state.touches[0].at;
    const Quat turn = m.from[0].rotation * c.on_a.pose.rotation;
    const nurbs::Jet p = c.on_a.skin->face(at.a.face).at(at.a.u, at.a.v);
    for (std::size_t i = 0; i < 2; ++i) {
      const Real by_differences =
          derivative([&](Real t) { return paper_forms(m, t).rolling[i]; }, 5e-5);
      CHECK(by_differences ==
            Approx(-glm::dot(turn * (i == 0 ? p.u : p.v), slip_rate)).margin(1e-8));
    }
  }
}

namespace {

/// The same bodies, moved until they touch and rolling there.
void let_roll(Meeting3& m) {
  RowsAt now = rows_at(m, 0);
  const Vec3 arm = lag::islands_of(m.world)[0].scratch.touching[0].arm[0];
  m.from[0].position -= now.c[0] * now.j[0];
  const Vec3 place = m.from[0].position + arm;
  m.from[0].velocity = m.from[1].velocity +
                       glm::cross(m.from[1].angular_velocity, place - m.from[1].position) -
                       glm::cross(m.from[0].angular_velocity, arm);
}

/// The rows of a meeting with other Jacobians.
RowsAt rows_with(Meeting3& m, Jacobians jacobians) {
  ready(m.world).settings.jacobians = jacobians;
  return rows_at(m, 0);
}

/// The largest difference of the Jacobians of rows `from` to 3, and of gamma, relative.
std::pair<Real, Real> apart(const RowsAt& x, const RowsAt& y, std::size_t from = 0) {
  Real j = 0, gamma = 0;
  for (std::size_t i = 4 * from; i < 16; ++i) j = std::max(j, glm::length(x.j[i] - y.j[i]));
  for (std::size_t r = from; r < 4; ++r)
    gamma = std::max(gamma, std::abs(x.gamma[r] - y.gamma[r]) / (1 + std::abs(x.gamma[r])));
  return {j, gamma};
}

}  // namespace

TEST_CASE("surfaces: rows by differences agree with the closed forms where bodies touch and roll") {
  std::mt19937 random(8);
  Real worst_j = 0, worst_gamma = 0;
  for (int n = 0; n < 40; ++n) {
    Meeting3 m = meeting(skins(n % 4), random);
    let_roll(m);
    const auto [j, gamma] =
        apart(rows_with(m, Jacobians::analytic), rows_with(m, Jacobians::differences));
    worst_j = std::max(worst_j, j), worst_gamma = std::max(worst_gamma, gamma);
  }
  CAPTURE(worst_j, worst_gamma);
  CHECK(worst_j <= 2e-11);
  CHECK(worst_gamma <= 2e-11);
  CHECK(worst_j > 0);  // they are other numbers
}

TEST_CASE("surfaces: differences are of order 2, and 4 when extrapolated") {
  std::mt19937 random(12);
  for (int n = 0; n < 8; ++n) {
    Meeting3 m = meeting(skins(n % 4), random);
    let_roll(m), rows_at(m, 0);
    const lag::Island& island = lag::islands_of(m.world)[0];
    const auto slopes = [&](Real step, bool extrapolated) {
      const lag::ContactSlopes s = lag::contact_slopes(m.world, island, 0, {step, extrapolated});
      REQUIRE(s.status == nurbs::ContactStatus::found);
      return s;
    };
    const lag::ContactSlopes exact = slopes(1e-3, true);
    const auto error = [&](Real step, bool extrapolated) {
      const lag::ContactSlopes s = slopes(step, extrapolated);
      Real worst = 0;
      for (int i = 0; i < 12; ++i)
        worst = std::max({worst, glm::length(s.on_a[i] - exact.on_a[i]),
                          glm::length(s.on_b[i] - exact.on_b[i])});
      return worst;
    };
    INFO(n);
    CHECK(std::log2(error(0.02, false) / error(0.01, false)) == Approx(2).margin(0.1));
    CHECK(std::log2(error(0.02, true) / error(0.01, true)) == Approx(4).margin(0.25));
  }
}

TEST_CASE("surfaces: the squared distance has a gradient of twice the gap, and none at contact") {
  std::mt19937 random(6);
  for (int n = 0; n < 20; ++n) {
    Meeting3 m = meeting(skins(n % 4), random);
    const RowsAt gap = rows_with(m, Jacobians::analytic),
                 squared = rows_with(m, Jacobians::squared_distance);
    INFO(n << ", gap " << gap.c[0]);
    CHECK(std::abs(squared.c[0]) == Approx(gap.c[0] * gap.c[0]).epsilon(1e-12));
    for (std::size_t i = 0; i < 4; ++i)
      CHECK(glm::length(squared.j[i] - 2 * std::abs(gap.c[0]) * gap.j[i]) <= 1e-9);
    ready(m.world).settings.jacobians = Jacobians::analytic;
    let_roll(m);
    const RowsAt touching = rows_with(m, Jacobians::squared_distance);
    for (std::size_t i = 0; i < 4; ++i) CHECK(touching.j[i] == Vec3(0));
    // Rolling is held as before.
    CHECK(apart(rows_with(m, Jacobians::analytic), touching, 1).first <= 1e-9);
  }
}

TEST_CASE("surfaces: differences lose a contact within a step of its rim, closed forms do not") {
  // A ball on a plate of 2 m, whose size is less than that of the ball, 1e-4 m from the rim.
  const auto step_with = [](Jacobians jacobians) {
    World w = exact_world(Integrator::rk4);
    w.gravity = Vec3(0), w.default_settings.jacobians = jacobians;
    Body plate;
    plate.motion = Motion::fixed;
    const Entity on = w.add_body(plate), ball = w.add_body(solid_ball(1, 2, {1 - 1e-4, 2, 0}));
    touch(w, {ball, ball_skin(Vec3(2)), on, flat_skin(2)}, SurfaceMotion::rolling);
    Simulation sim(std::move(w), {1e-3});
    return sim.step().status;
  };
  CHECK(step_with(Jacobians::analytic) == Status::ok);
  CHECK(step_with(Jacobians::differences) == Status::contact_lost);
}
