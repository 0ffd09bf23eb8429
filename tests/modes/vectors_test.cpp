// Contact modes against tests/data/quasistatic.json: numbers at double precision, each found by an
// independent route.
#include <catch2/catch.hpp>
#include <fstream>
#include <set>

#include "engine/modes/feasible.hpp"
#include "tests/modes/grasps.hpp"
#include "tests/paths.hpp"

using namespace pantin;
using namespace pantin::test;
using nlohmann::json;

json pantin::test::quasistatic_vectors() {
  std::ifstream file(test_data("quasistatic.json"));
  return json::parse(file);
}

namespace {

std::vector<json> all_grasps() {
  const json all = quasistatic_vectors();
  std::vector<json> list;
  for (const char* group : {"grasps", "figure_grasps"})
    for (const json& g : all[group]) list.push_back(g);
  return list;
}

std::vector<Real> numbers(const json& list) { return list.get<std::vector<Real>>(); }

const Candidate& candidate(const Prepared& p, const json& mode) {
  for (const Candidate& c : p.candidates) {
    if ((mode["kind"] == "3S") != (c.kind == Kind::three_slide)) continue;
    if (name_of(p, c) == mode["string"].get<std::string>()) return c;
  }
  FAIL("no candidate " << mode["string"]);
  return p.candidates.front();
}

const Region& region(const Prepared& p, const json& mode) {
  const Candidate& c = candidate(p, mode);
  REQUIRE(c.region >= 0);
  return p.regions[static_cast<std::size_t>(c.region)];
}

/// Every allowed mode of every grasp.
void each_mode(auto&& look) {
  int seen = 0;
  for (const json& grasp : all_grasps()) {
    const Prepared p = prepared(read_grasp(grasp));
    for (const json& mode : grasp["modes"]) {
      if (mode["status"] != "ok") continue;
      CAPTURE(grasp["name"], mode["string"]);
      look(region(p, mode), mode), ++seen;
    }
  }
  CHECK(seen > 40);
}

struct Named {
  const char* name;
  Real value;
};

std::vector<Named> coefficients(const Region& r) {
  const auto& x = r.divisor;
  const auto& f = r.forms;
  if (r.kind == Kind::roll_slide)
    return {{"A", x[2]},     {"B", x[0]},     {"C1", f[1][3]}, {"D1", f[1][1]},
            {"C2", f[1][2]}, {"D2", f[1][0]}, {"D3", f[0][0]}};
  return {{"A", x[7]},      {"B1", x[3]},    {"B2", x[5]},     {"B3", x[6]},     {"C1", x[1]},
          {"C2", x[2]},     {"C3", x[4]},    {"D", x[0]},      {"E1", f[0][3]},  {"F12", f[0][1]},
          {"F13", f[0][2]}, {"G1", f[0][0]}, {"E2", f[1][3]},  {"F21", f[1][1]}, {"F23", f[1][2]},
          {"G2", f[1][0]},  {"E3", f[2][3]}, {"F31", f[2][1]}, {"F32", f[2][2]}, {"G3", f[2][0]}};
}

bool near(Real a, Real b, Real relative) {
  return std::abs(a - b) <= relative * std::max({1.0, std::abs(a), std::abs(b)});
}

}  // namespace

TEST_CASE("each candidate has the motion and the status that the fingers give it") {
  for (const json& grasp : all_grasps()) {
    const Prepared p = prepared(read_grasp(grasp));
    CHECK(p.candidates.size() == grasp["modes"].size());
    for (const json& mode : grasp["modes"]) {
      CAPTURE(grasp["name"], mode["string"]);
      const Candidate& c = candidate(p, mode);
      CHECK(word_for(c.status) == mode["status"].get<std::string>());
      if (c.region < 0) continue;
      const Region& r = region(p, mode);
      for (int i = 0; i < 3; ++i) CHECK(near(r.twist[i], mode["q"][i].get<Real>(), 1e-9));
      const bool slides = r.kind == Kind::three_slide;
      for (std::size_t k = 0; k < mode["xi"].size(); ++k) {
        CHECK(r.slip_sign[slides ? k : 1] == mode["xi"][k].get<int>());
        CHECK(near(r.slip[slides ? k : 1], mode["slip"][k].get<Real>(), 1e-9));
      }
    }
  }
}

TEST_CASE("coefficients of the regions agree with 40-digit arithmetic") {
  each_mode([](const Region& r, const json& mode) {
    Real largest = 0;
    for (const auto& [key, value] : mode["coef"].items())
      largest = std::max(largest, std::abs(value.get<Real>()));
    const auto own = coefficients(r);
    CHECK(own.size() == mode["coef"].size());
    for (const auto& [name, value] : own) {
      CAPTURE(name);
      CHECK(std::abs(value - mode["coef"][name].get<Real>()) <= 1e-12 * largest);
    }
  });
}

TEST_CASE("regions hold the points of the grids and no others") {
  int tested = 0;
  each_mode([&](const Region& r, const json& mode) {
    const std::string grid = mode["grid"];
    const std::size_t variables = static_cast<std::size_t>(r.variables());
    for (std::size_t at = 0; at < grid.size(); ++at) {
      if (grid[at] == 'x') continue;
      OwnFriction mu{};
      for (std::size_t k = variables, rest = at; k-- > 0; rest /= 9)
        mu[k] = 0.15 * static_cast<Real>(rest % 9);
      if (contains(r, mu) != (grid[at] == '1')) FAIL("grid point " << at);
      ++tested;
    }
  });
  CHECK(tested > 15000);
}

TEST_CASE("intervals of a common coefficient and cube bounds are those of the vectors") {
  each_mode([](const Region& r, const json& mode) {
    const Intervals all = equal_friction(r);
    REQUIRE(static_cast<std::size_t>(all.count) == mode["equal_mu"].size());
    for (std::size_t i = 0; i < mode["equal_mu"].size(); ++i) {
      const json& expected = mode["equal_mu"][i];
      CHECK(std::abs(all.list[i].low - expected[0].get<Real>()) <= 1e-9);
      if (expected[1].is_null())
        CHECK(std::isinf(all.list[i].high));
      else
        CHECK(std::abs(all.list[i].high - expected[1].get<Real>()) <=
              1e-9 * std::max(1.0, all.list[i].high));
    }
    if (!mode.contains("cube_bound")) return;
    if (mode["cube_bound"].is_null())
      CHECK(std::isinf(cube_bound(r)));
    else
      CHECK(near(cube_bound(r), mode["cube_bound"].get<Real>(), 1e-9));
  });
}

TEST_CASE("samples have the modes, forces, indices and classes of the vectors") {
  int tested = 0;
  std::set<std::string> kinds;
  for (const json& grasp : all_grasps()) {
    const Prepared p = prepared(read_grasp(grasp));
    for (const json& sample : grasp["samples"]) {
      CAPTURE(grasp["name"], tested);
      const auto roll = numbers(sample["mu_roll"]), slide = numbers(sample["mu_slide"]);
      ModeSet set;
      find_modes(p, {roll, slide}, set);
      const json& expected = sample["feasible"];
      REQUIRE(set.modes.size() == expected.size());
      CHECK(set.indeterminate.empty());
      for (std::size_t i = 0; i < expected.size(); ++i) {
        const FeasibleMode& mode = set.modes[i];
        const Region& r = p.regions[static_cast<std::size_t>(mode.region)];
        CHECK(name_of(p, r) == expected[i]["string"].get<std::string>());
        CHECK(mode.index == expected[i]["index"].get<int>());
        for (std::size_t k = 0; k < 3; ++k)
          CHECK(near(mode.force[k], expected[i]["c"][k].get<Real>(), 1e-9));
      }
      const std::string kind = sample["class"];
      const bool one = set.verdict == Verdict::unique || set.verdict == Verdict::ambiguous;
      CHECK(one == (kind == "ok"));
      CHECK((set.verdict == Verdict::squeezed) == (kind == "kin"));
      CHECK((set.verdict == Verdict::no_balance) == (kind == "noeq"));
      CHECK((set.verdict == Verdict::conflict) == (kind == "conflict"));
      kinds.insert(kind), ++tested;
    }
  }
  CHECK(tested >= 60);
  CHECK(kinds.count("ok") + kinds.count("conflict") + kinds.count("noeq") == 3);
}

TEST_CASE("degenerate grasps have the statuses and the signed modes of the vectors") {
  const json all = quasistatic_vectors();
  REQUIRE(all["degenerate"].size() == 9);
  for (const json& d : all["degenerate"]) {
    CAPTURE(d["name"]);
    const Prepared p = prepared(read_grasp(d));
    for (const Candidate& c : p.candidates)
      CHECK(word_for(c.status) == d["square_status"][name_of(p, c)].get<std::string>());
    const auto mu = numbers(d["mu"]);
    ModeSet set;
    find_modes(p, Friction::same(mu), set);
    CHECK(set.degenerate);
    std::multiset<std::string> names;
    for (const FeasibleMode& m : set.modes)
      if (!m.break_tie)  // listed with a flag; the tied contact does not separate
        names.insert(name_of(signs_of(p.regions[static_cast<std::size_t>(m.region)]), p.count));
    for (const SignedMode& m : set.indeterminate) names.insert(name_of(m.signs, p.count));
    CHECK(names == d["signed_modes_LP"].get<std::multiset<std::string>>());
    const std::size_t count = names.size();
    CHECK((set.verdict == Verdict::unique) == (count == 1));
    CHECK((set.verdict == Verdict::ambiguous) == (count > 1));
    SignedModes search;
    find_signed_modes(p, Friction::same(mu), search);
    CHECK(search.complete);
    CHECK(search.list.size() == d["signed_modes_LP"].size());
  }
}
