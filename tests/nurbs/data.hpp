#pragma once
/// The vectors of tests/data/nurbs.json, which tests/data/nurbs.py made.
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/nurbs/spline.hpp"
#include "tests/paths.hpp"

namespace pantin::test {

using nlohmann::json;

inline const json& nurbs_data() {
  static const json kAll = json::parse(std::ifstream(test_data("nurbs.json")));
  return kAll;
}

inline Vec3 vector_of(const json& j) { return {j[0], j[1], j[2]}; }

/// A surface of the section `surfaces`.
inline detail::nurbs::Surface surface_of(const std::string& name) {
  const json& j = nurbs_data()["surfaces"][name];
  detail::nurbs::Surface s{
      {j["p"], j["U"], j["periodic_u"]}, {j["q"], j["V"], j["periodic_v"]}, {}};
  for (std::size_t i = 0; i < j["P"].size(); ++i)
    for (std::size_t k = 0; k < j["P"][i].size(); ++k)
      s.points.push_back({vector_of(j["P"][i][k]), j["w"][i][k]});
  return s;
}

}  // namespace pantin::test
