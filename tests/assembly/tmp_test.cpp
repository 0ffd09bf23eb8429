#include <catch2/catch.hpp>
#include <cstdio>
#include "tests/assembly/mechanisms.hpp"
using namespace pantin;
using namespace pantin::test;
using namespace pantin::detail::assembly;
TEST_CASE("tmp trace", "[.]") {
  for (const World& m : {stewart(), polygon(3), bendy(8)}) {
    World w = m;
    scatter(w, 1003, 1, {});
    AssemblyChoices c;
    c.watch = [](const Iteration& i) { std::printf("%3d res %.3e merit %.3e mu %.1e\n", i.number, i.residual, i.merit, i.damping); };
    const auto r = assemble(w, c);
    std::printf("rows %zu rank %zu mobility %ld turned %d starts %d\n", r.rows, r.rank, long(r.mobility), r.turned_over, r.starts);
  }
}
