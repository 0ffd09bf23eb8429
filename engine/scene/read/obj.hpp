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

/// Reads the lines `v x y z` and `f i j k ...`; all others are passed over. Faces of more than
/// three corners become fans about their first. Corners may be i, i/j, i//k or i/j/k, of which i
/// counts, from 1, or from the last point backwards if negative. Complaints begin "name:line: "; at
/// most twenty are reported.
Result<ObjMesh> parse_obj(std::string_view text, std::string_view name);

}  // namespace pantin::detail
