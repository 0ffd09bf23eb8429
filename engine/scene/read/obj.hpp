#pragma once
/// Wavefront OBJ: points and faces.
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/math.hpp"
#include "engine/base/result.hpp"

namespace pantin::detail {

struct ObjMesh {
  std::vector<Vec3> points;  // as written
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Reads the lines `v x y z` and `f i j k ...`; ignores all others. Faces with more than three
/// corners are split into fans about their first. Corners may be i, i/j, i//k or i/j/k, of which i
/// counts, from 1, or backwards from the last point if negative. Errors begin with "name:line: ";
/// at most twenty are reported.
Result<ObjMesh> parse_obj(std::string_view text, std::string_view name);

}  // namespace pantin::detail
