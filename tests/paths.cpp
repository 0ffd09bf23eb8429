#include "tests/paths.hpp"

std::string test_data(const std::string& name) { return PANTIN_TEST_DATA "/" + name; }
std::string asset(const std::string& name) { return PANTIN_ASSETS "/" + name; }
