#pragma once
// Arrays for numpy: a .npz file is a ZIP archive without compression of .npy files.
#include <span>
#include <string>
#include <vector>

#include "engine/base/atomic_file.hpp"
#include "engine/base/math.hpp"

namespace pantin::program {

using namespace detail;

/// A named array of one dimension.
struct NpzArray {
  std::string name;
  std::vector<Real> values;
};

/// Appends the archive to an open file: one little-endian float64 array each, readable by
/// numpy.load(). An error if the archive would exceed 4 GiB, the limit of the format without ZIP64.
/// [PKWARE APPNOTE 6.3, numpy.lib.format version 1.0]
Result<Done> write_npz(std::span<const NpzArray> arrays, AtomicFile& file);

}  // namespace pantin::program
