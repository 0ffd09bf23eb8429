#pragma once
/// Forms of the constraint of surfaces that touch, what they cost and how exact they are.
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string_view>

#include "tools/study/problems.hpp"

namespace pantin::study {

/// How the rows of a contact and their rates are found.
enum class SurfaceForm : std::uint8_t {
  analytic,         // the gap and its rates in closed form, as the solver has them
  gap_central,      // the gap's row and gamma by central differences over all coordinates
  gap_richardson,   // the same, extrapolated once
  paper_central,    // C_p, C_tan and C_roll of [Nelson & Cohen, Eqns 3-13] by central differences
  paper_richardson  // the same, extrapolated once
};

inline constexpr const char* kFormNames =
    "analytic, gap_central, gap_richardson, paper_central or paper_richardson";
std::optional<SurfaceForm> form_named(std::string_view name);

/// Error after a second and CPU time a step (Runge-Kutta of order 4 with projection) of a ball on a
/// turntable and a leaning wheel, by form and by the step of the differences, comma separated. Of
/// one form, or of all.
enum class FormSteps : std::uint8_t { few, all };
void measure_surface_forms(std::FILE* out, FormSteps steps, std::optional<SurfaceForm> only);

}  // namespace pantin::study
