#pragma once
/// Builds figures of several parts. Not installed.
#include <pantin/world.hpp>
#include <string>
#include <vector>

namespace pantin::detail {

/// Adds objects one by one; on failure it removes those added so far.
class Builder {
 public:
  Builder(World& world, std::string name) : world_(world), name_(std::move(name)) {}

  template <class T>
  Entity add(T described, const std::string& part) {
    if (!errors_.empty()) return {};
    if (!name_.empty()) described.name = name_ + '/' + part;
    Result<Entity> made = world_.add(described);
    if (!made) {
      errors_ = made.errors();
      world_.destroy(made_);
      return {};
    }
    made_.push_back(*made);
    return *made;
  }
  std::vector<Error> take() { return std::move(errors_); }
  bool ok() const { return errors_.empty(); }

 private:
  World& world_;
  std::string name_;
  std::vector<Entity> made_;
  std::vector<Error> errors_;
};

}  // namespace pantin::detail
