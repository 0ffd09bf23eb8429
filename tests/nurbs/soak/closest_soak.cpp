// A million nearest points: pantin_tests "a million*"
#include "tests/nurbs/dense.hpp"

using namespace pantin;
using namespace pantin::test;

TEST_CASE("a million nearest points are those of dense samples", "[.soak]") {
  const Tally tally = ask_around(1000, 1000, 2);
  WARN("brute force missed " << tally.brute_missed << ", at creases " << tally.at_creases
                             << ", uncertain " << tally.uncertain << ", looks a query "
                             << static_cast<Real>(tally.looks) / tally.queries);
  CHECK(tally.unexplained == 0);
  CHECK(tally.queries == 1000000);
}
