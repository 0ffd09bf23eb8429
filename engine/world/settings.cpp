#include "engine/world/settings.hpp"

#include <array>
#include <string_view>
#include <utility>

namespace pantin {

using namespace detail;

namespace {

constexpr std::array<std::pair<Solver, const char*>, 5> kNames{
    {{Solver::articulated, "auto"},
     {Solver::sweep, "sweep"},
     {Solver::shake2, "shake2"},
     {Solver::procedural, "procedural"},
     {Solver::lagrangian, "lagrangian"}}};

}  // namespace

const char* name_of(Solver solver) {
  for (const auto& [value, name] : kNames)
    if (value == solver) return name;
  return "?";
}

bool solver_from_name(const char* name, Solver& solver) {
  if (!name) return false;
  for (const auto& [value, known] : kNames)
    if (std::string_view(name) == known) {
      solver = value;
      return true;
    }
  return false;
}

}  // namespace pantin
