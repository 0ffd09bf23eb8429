#pragma once
/// Errors in a description, collected while it is checked. Not installed.
#include <initializer_list>
#include <pantin/world.hpp>
#include <span>
#include <string>
#include <vector>

#include "engine/world/faults.hpp"

namespace pantin::detail {

/// A number as a message shows it.
std::string shown(Real number);
std::string shown(Vec3 v);

/// Collects errors of the form "HingeJoint 'knee': axis: found (0, 0, 0), expected ...".
class Findings {
 public:
  Findings(const World& world, const char* type, const std::string& name);

  void add(const char* member, const std::string& found, const std::string& expected);
  bool ok() const { return errors_.empty(); }
  std::vector<Error> take() { return std::move(errors_); }

  void above_zero(const char* member, Real number);
  void not_negative(const char* member, Real number);
  void within(const char* member, Real number, Real low, Real high);
  void finite(const char* member, Real number);
  void finite(const char* member, Vec3 v);
  void finite(const char* member, const Pose& pose);
  /// A direction: finite and not zero; returned with unit length.
  Vec3 direction(const char* member, Vec3 v);
  /// A rotation: finite and not zero; returned with unit length.
  Quat rotation(const char* member, Quat q);
  /// A living entity with a body.
  void body(const char* member, Entity e);
  /// Two different bodies, one of them dynamic.
  void bodies(Entity a, Entity b);
  /// Checks that the solver which would move these bodies together, at present, supports the
  /// features.
  void known(std::span<const Feature> features, std::initializer_list<Entity> bodies);

  const World& world() const { return world_; }

 private:
  const World& world_;
  std::string who_;
  std::vector<Error> errors_;
};

}  // namespace pantin::detail
