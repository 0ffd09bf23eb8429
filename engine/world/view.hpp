#pragma once
/// Entities that have several components at once, as a range.
///
/// Internal (pantin::detail); installed because World::view() gives it back.
#include <iterator>
#include <tuple>
#include <type_traits>

#include "engine/world/store.hpp"

namespace pantin::detail {

/// The store of a component type in a World (const or not): a built-in or a user's. Null if a const
/// World has no store of a user's type.
template <class T, class W>
auto* find_store(W& world) {
  using Found = std::conditional_t<std::is_const_v<W>, const Store<T>, Store<T>>;
  Found* found = nullptr;
  const auto look = [&](auto&... stores) {
    const auto one = [&](auto& store) {
      if constexpr (std::is_same_v<decltype(&store), Found*>) found = &store;
    };
    (one(stores), ...);
  };
  look(world.bodies, world.forces, world.origins, world.shapes, world.links, world.cables,
       world.gears, world.belts, world.surface_contacts, world.pins, world.paths,
       world.joint_drives, world.collisions, world.names, world.settings);
  if (found) return found;
  if constexpr (std::is_const_v<W>)
    return world.user.template find<T>();
  else
    return &world.user.template of<T>();
}

template <class W, class First, class... Others>
class ComponentView {
  template <class T>
  using Kept = std::conditional_t<std::is_const_v<W>, const Store<T>, Store<T>>;
  template <class T>
  using Seen = std::conditional_t<std::is_const_v<W>, const T&, T&>;

 public:
  explicit ComponentView(W& world)
      : stores_(find_store<First>(world), find_store<Others>(world)...) {}

  class Iterator {
   public:
    using value_type = std::tuple<Entity, Seen<First>, Seen<Others>...>;
    using difference_type = std::ptrdiff_t;

    Iterator() = default;
    Iterator(const ComponentView& view, std::size_t at) : view_(&view), at_(at) { skip(); }
    value_type operator*() const {
      auto* first = std::get<0>(view_->stores_);
      const Entity owner = first->owners()[at_];
      return value_type(owner, first->values()[at_],
                        *std::get<Kept<Others>*>(view_->stores_)->find(owner)...);
    }
    Iterator& operator++() {
      ++at_, skip();
      return *this;
    }
    Iterator operator++(int) {
      const Iterator before = *this;
      ++*this;
      return before;
    }
    bool operator==(const Iterator& other) const { return at_ == other.at_; }

   private:
    void skip() {
      while (at_ < view_->size() && !view_->has_all(at_)) ++at_;
    }
    const ComponentView* view_ = nullptr;
    std::size_t at_ = 0;
  };

  Iterator begin() const { return {*this, 0}; }
  Iterator end() const { return {*this, size()}; }
  bool empty() const { return begin() == end(); }

 private:
  std::size_t size() const { return std::get<0>(stores_) ? std::get<0>(stores_)->size() : 0; }
  bool has_all(std::size_t at) const {
    [[maybe_unused]] const Entity owner = std::get<0>(stores_)->owners()[at];
    return ([&](const auto* store) {
      return store && store->slot(owner) != kNoSlot;
    }(std::get<Kept<Others>*>(stores_)) &&
            ...);
  }

  std::tuple<Kept<First>*, Kept<Others>*...> stores_;
};

}  // namespace pantin::detail
