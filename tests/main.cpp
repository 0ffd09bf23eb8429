// The program of the tests. Every file is a tag: "[#limits_test]" runs those of limits_test.cpp.
// Catch's own main is slow to compile and lives alone here.
#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>

int main(int count, char** words) {
  Catch::Session session;
  session.configData().filenamesAsTags = true;
  const int wrong = session.applyCommandLine(count, words);
  return wrong != 0 ? wrong : session.run();
}
