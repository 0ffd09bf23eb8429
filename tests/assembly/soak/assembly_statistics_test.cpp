// Far random starts: the share that is assembled, and the iterations.
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "tests/assembly/mechanisms.hpp"

using namespace pantin;
using namespace pantin::test;
using namespace pantin::detail::assembly;

namespace {

struct Statistics {
  int assembled = 0, first = 0, starts = 0;
  int median = 0, worst = 0;  // iterations of those assembled, all starts together
  int near = 0;               // median of the iterations to a residual of 1e-2
  double us = 0;              // per iteration
};

Statistics statistics(const World& model, Real spread, int count, int starts) {
  Statistics s;
  std::vector<int> iterations, to_near;
  int all = 0;
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < count; ++i) {
    World w = model;
    scatter(w, 1000 + static_cast<std::uint64_t>(i), spread, {});
    AssemblyChoices choices;
    choices.starts = starts, choices.finds_contradictions = false, choices.seed = 7;
    int seen = 0, near = -1;
    choices.watch = [&](const Iteration& at) {
      if (near < 0 && at.residual < 1e-2) near = seen;
      ++seen;
    };
    const AssemblyReport report = assemble(w, choices);
    to_near.push_back(near);
    s.assembled += report.assembled, s.first += report.assembled && report.starts == 0;
    s.starts = std::max(s.starts, report.starts);
    all += report.iterations;
    if (report.assembled) iterations.push_back(report.iterations);
  }
  const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - begin;
  s.us = took.count() / std::max(1, all);
  std::sort(iterations.begin(), iterations.end());
  std::sort(to_near.begin(), to_near.end());
  s.near = to_near[to_near.size() / 2];
  if (!iterations.empty())
    s.median = iterations[iterations.size() / 2], s.worst = iterations.back();
  return s;
}

}  // namespace

TEST_CASE("assembly: statistics of far starts", "[.long]") {
  const struct {
    const char* name;
    World world;
    Real spread;
  } cases[] = {{"bendy 4", bendy(4), 3}, {"bendy 8", bendy(8), 3},  {"bendy 20", bendy(20), 3},
               {"bent 6", bent(6), 1},   {"Stewart", stewart(), 1}, {"four-bar", polygon(3), 1},
               {"Bricard", bricard(), 1}};
  const char* count = std::getenv("PANTIN_STARTS");
  for (const auto& c : cases) {
    const Statistics s = statistics(c.world, c.spread, count ? std::atoi(count) : 1000, 24);
    std::printf(
        "%-10s assembled %4d, first start %4d, restarts at most %2d; iterations median %3d, "
        "worst %4d, to 1e-2 %3d; %.1f us each\n",
        c.name, s.assembled, s.first, s.starts, s.median, s.worst, s.near, s.us);
    std::fflush(stdout);
    CHECK(s.assembled > 0);
  }
}
