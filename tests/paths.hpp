#pragma once
/// Where the files are that tests read. A unit of their own: other units do not depend on where the
/// checkout lies.
#include <string>

std::string test_data(const std::string& name);  // in tests/data
std::string asset(const std::string& name);      // in assets
