#include "engine/modes/path.hpp"

namespace pantin::detail::modes {
namespace {

/// Without friction a mode of three sliding contacts is unique.
const Region* frictionless(const Prepared& p) {
  for (const Region& r : p.regions)
    if (r.kind == Kind::three_slide && contains(r, {})) return &r;
  return nullptr;
}

void lower(Real& bound, int& at, Real found, int pose) {
  if (found < bound) bound = found, at = pose;
}

}  // namespace

void PathBound::add(const Prepared& pose) {
  const int number = poses++;
  const Region* r = frictionless(pose);
  if (!r) {
    ++without_plan;
    lower(each, pose_of_each, 0, number);
    lower(common, pose_of_common, 0, number);
    return;
  }
  if (number > without_plan && r->contacts != contacts) ++changes;
  contacts = r->contacts;
  lower(each, pose_of_each, cube_bound(*r), number);
  lower(common, pose_of_common, equal_friction(*r).list[0].high, number);
}

}  // namespace pantin::detail::modes
