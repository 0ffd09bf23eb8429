#pragma once
/// Dense storage of one component type, in insertion order.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <span>
#include <string_view>
#include <typeinfo>
#include <utility>
#include <vector>

#include "engine/base/archive.hpp"
#include "engine/base/check.hpp"
#include "engine/base/hash.hpp"
#include "engine/world/entity.hpp"

namespace pantin {

inline constexpr std::uint32_t kNoSlot = UINT32_MAX;

namespace detail {
/// Throws std::out_of_range: the entity has no such component, or no longer exists.
[[noreturn]] void throw_missing(Entity owner);
}  // namespace detail

/// A dense array of `T` with the entity that owns each value.
///
/// Iteration follows insertion order, also after removals, so that runs are reproducible. `version`
/// changes whenever a value is added or removed. References stay valid until the next addition or
/// removal.
template <class T>
class Store {
 public:
  using Component = T;

  /// Adds a component to `owner`, or replaces the existing one in place. A value for the null
  /// handle is discarded. A value for a destroyed entity is stored, but the next step removes and
  /// reports it: see StepReport::faults.
  T& add(Entity owner, T value) {
    if (!owner) {
      thread_local T aside;
      return aside = std::move(value);
    }
    if (T* old = find(owner)) {
      ++version_, ++replaced_;
      if (!is_new(slots_[owner.index])) keep_gone(owner, std::move(*old));
      return *old = std::move(value);
    }
    if (owner.index >= slots_.size()) slots_.resize(owner.index + 1, kNoSlot);
    hides_ = hides_ || slots_[owner.index] != kNoSlot;
    slots_[owner.index] = static_cast<std::uint32_t>(values_.size());
    owners_.push_back(owner);
    values_.push_back(std::move(value));
    ++version_;
    return values_.back();
  }

  /// Removes the components of all `doomed` entities in one pass; the order is kept.
  void remove(std::span<const Entity> doomed) {
    std::size_t first = values_.size();
    for (Entity e : doomed) {
      const std::uint32_t at = slot(e);
      if (at == kNoSlot) continue;
      if (!is_new(at)) keep_gone(e, std::move(values_[at]));
      owners_[at] = Entity{};
      slots_[e.index] = kNoSlot;
      first = std::min<std::size_t>(first, at);
    }
    if (first == values_.size()) return;
    if (hides_) first = 0;  // what the removed values hid is found again
    std::vector<std::uint32_t> now(first_new_ == kNoSlot ? 0 : values_.size(), kNoSlot);
    std::iota(now.begin(), now.begin() + static_cast<std::ptrdiff_t>(now.empty() ? 0 : first), 0u);
    std::size_t kept = first;
    for (std::size_t i = first; i < values_.size(); ++i) {
      if (!owners_[i]) continue;
      if (!now.empty()) now[i] = static_cast<std::uint32_t>(kept);
      if (kept != i) values_[kept] = std::move(values_[i]), owners_[kept] = owners_[i];
      slots_[owners_[kept].index] = static_cast<std::uint32_t>(kept);
      ++kept;
    }
    values_.erase(values_.begin() + static_cast<std::ptrdiff_t>(kept), values_.end());
    owners_.erase(owners_.begin() + static_cast<std::ptrdiff_t>(kept), owners_.end());
    ++version_, ++removed_;
    if (!now.empty()) note_moves(std::move(now));
  }
  void remove(Entity owner) { remove(std::span<const Entity>(&owner, 1)); }

  /// The index of the owner's value in `values()`, or kNoSlot.
  std::uint32_t slot(Entity owner) const {
    if (owner.index >= slots_.size()) return kNoSlot;
    const std::uint32_t s = slots_[owner.index];
    return s != kNoSlot && owners_[s] == owner ? s : kNoSlot;
  }

  T* find(Entity owner) {
    const std::uint32_t s = slot(owner);
    return s == kNoSlot ? nullptr : &values_[s];
  }
  const T* find(Entity owner) const {
    const std::uint32_t s = slot(owner);
    return s == kNoSlot ? nullptr : &values_[s];
  }

  /// The value of an owner that has one; throws std::out_of_range for any other.
  T& operator[](Entity owner) {
    if (T* found = find(owner)) return *found;
    detail::throw_missing(owner);
  }
  const T& operator[](Entity owner) const {
    if (const T* found = find(owner)) return *found;
    detail::throw_missing(owner);
  }

  std::span<T> values() { return values_; }
  std::span<const T> values() const { return values_; }
  std::span<const Entity> owners() const { return owners_; }
  std::size_t size() const { return values_.size(); }
  bool empty() const { return values_.empty(); }
  std::uint64_t version() const { return version_; }
  /// How many values were replaced or removed.
  std::uint64_t replaced() const { return replaced_; }
  std::uint64_t removed() const { return removed_; }

  void reserve(std::size_t count) {
    values_.reserve(count);
    owners_.reserve(count);
  }

  /// Starts tracking: slot_now() tells where later removals move values. Costs no memory until
  /// something is removed.
  void track_slots() {
    moved_ = {}, first_new_ = static_cast<std::uint32_t>(size());
    gone_.clear(), has_forgotten_ = false;
  }
  /// Whether something was removed since track_slots().
  bool has_moved() const { return !moved_.empty(); }
  /// The present slot of the value that was in `slot` at the last track_slots(); kNoSlot if it was
  /// removed since.
  std::uint32_t slot_now(std::uint32_t slot) const {
    if (moved_.empty()) return slot;
    return slot < moved_.size() ? moved_[slot] : kNoSlot;
  }
  /// The first slot whose value is now in another one, or removed; kNoSlot: none.
  std::uint32_t first_moved() const {
    for (std::uint32_t i = 0; i < moved_.size(); ++i)
      if (moved_[i] != i) return i;
    return kNoSlot;
  }
  /// The inverse: the slot at track_slots() of the value now in `slot`; kNoSlot for kNoSlot and for
  /// a value added since. Linear in the number of values after a removal.
  std::uint32_t slot_then(std::uint32_t slot) const {
    if (slot == kNoSlot || is_new(slot)) return kNoSlot;
    if (moved_.empty()) return slot;
    const auto found = std::find(moved_.begin(), moved_.end(), slot);
    return found == moved_.end() ? kNoSlot : static_cast<std::uint32_t>(found - moved_.begin());
  }
  /// Whether the value in `slot` was added since track_slots().
  bool is_new(std::uint32_t slot) const { return slot >= first_new_; }
  /// The first slot that is_new(); kNoSlot before track_slots().
  std::uint32_t first_new() const { return first_new_; }

  /// A value that was removed or replaced.
  struct Gone {
    Entity owner;
    T value;
  };
  /// The values of track_slots() that were removed or replaced since, in this order; null if there
  /// were more than kMostGone.
  const std::vector<Gone>* gone() const { return has_forgotten_ ? nullptr : &gone_; }

  static void fields(auto& self, auto&& field) {
    field("values", self.values_);
    field("owners", self.owners_);
    field("slots", derived(self.slots_));
    field("version", passive(self.version_));
    field("replaced", passive(self.replaced_));
    field("removed", derived(self.removed_));
    field("moved", derived(self.moved_));
    field("first_new", derived(self.first_new_));
    field("gone", derived(self.gone_));
    field("has_forgotten", derived(self.has_forgotten_));
    field("hides", derived(self.hides_));
  }
  /// Rebuilds the slots from the owners after reading; returns null, or the fault.
  const char* restored(const detail::Entities& entities) {
    if (owners_.size() != values_.size()) return "has different numbers of owners and values";
    slots_.clear(), moved_ = {}, first_new_ = kNoSlot;
    gone_.clear(), has_forgotten_ = hides_ = false;
    for (std::size_t i = 0; i < owners_.size(); ++i) {
      const Entity owner = owners_[i];
      if (!entities.is_alive(owner)) return "has an owner that does not exist";
      if (owner.index >= slots_.size()) slots_.resize(owner.index + 1, kNoSlot);
      if (slots_[owner.index] != kNoSlot) return "has two values for one owner";
      slots_[owner.index] = static_cast<std::uint32_t>(i);
    }
    return nullptr;
  }

 private:
  static constexpr std::size_t kMostGone = 1024;

  void keep_gone(Entity owner, T&& value) {
    if (first_new_ == kNoSlot || has_forgotten_) return;
    has_forgotten_ = gone_.size() == kMostGone;
    if (has_forgotten_)
      gone_ = {};
    else
      gone_.push_back({owner, std::move(value)});
  }
  /// Records a removal: `now` holds the new slots, by slot before it.
  void note_moves(std::vector<std::uint32_t> now) {
    const auto still = [](std::uint32_t slot) { return slot != kNoSlot; };
    const auto old = now.begin() + std::min<std::ptrdiff_t>(first_new_, std::ssize(now));
    first_new_ = static_cast<std::uint32_t>(std::count_if(now.begin(), old, still));
    for (std::uint32_t& slot : moved_)
      if (still(slot)) slot = now[slot];
    if (moved_.empty()) moved_ = std::move(now);
  }

  std::vector<T> values_;
  std::vector<Entity> owners_;
  std::vector<std::uint32_t> slots_;
  std::uint64_t version_ = 0, replaced_ = 0, removed_ = 0;
  std::vector<std::uint32_t> moved_;   // by slot at track_slots(): the present slot; empty:
                                       // unchanged
  std::uint32_t first_new_ = kNoSlot;  // the first slot added since; kNoSlot: not tracked
  std::vector<Gone> gone_;
  bool has_forgotten_ = false;
  bool hides_ = false;  // a value was added for an entity whose index another one with a value has
};

namespace detail {

/// Type-erased store of a user's component type.
class AnyStore {
 public:
  virtual ~AnyStore() = default;
  virtual std::unique_ptr<AnyStore> clone() const = 0;
  virtual void remove(std::span<const Entity> doomed) = 0;
  virtual void add_to(Hash& hash, const EntityRule& rule) const = 0;
  virtual const void* type() const = 0;
  virtual std::size_t size() const = 0;
  /// `T::name` of the component, or the compiler's name of the type.
  virtual std::string_view name() const = 0;
  /// A fingerprint of its fields; 0 if it has none and cannot be saved.
  virtual std::uint64_t fingerprint() const = 0;
  virtual void write(FieldWriter& to) const = 0;
  /// Returns null, or the fault.
  virtual const char* read(FieldReader& from, const Entities& entities) = 0;
};

/// Its address identifies the type `T`.
template <class T>
inline constexpr char kTypeName = 0;

template <class T>
class UserStore final : public AnyStore {
 public:
  Store<T> store;

  std::unique_ptr<AnyStore> clone() const override { return std::make_unique<UserStore>(*this); }
  void remove(std::span<const Entity> doomed) override { store.remove(doomed); }
  void add_to([[maybe_unused]] Hash& hash, [[maybe_unused]] const EntityRule& rule) const override {
    if constexpr (HasFields<T>) {
      for (std::size_t i = 0; i < store.size(); ++i) {
        hash.add(store.owners()[i].index);
        hash_fields(hash, store.values()[i], rule);
      }
    }
  }
  const void* type() const override { return &kTypeName<T>; }
  std::size_t size() const override { return store.size(); }
  std::string_view name() const override {
    if constexpr (requires { std::string_view(T::name); })
      return T::name;
    else
      return typeid(T).name();
  }
  std::uint64_t fingerprint() const override {
    if constexpr (HasFields<T>) return fields_fingerprint<T>() | 1;
    return 0;
  }
  void write([[maybe_unused]] FieldWriter& to) const override {
    if constexpr (HasFields<T>) to.write(store);
  }
  const char* read([[maybe_unused]] FieldReader& from,
                   [[maybe_unused]] const Entities& entities) override {
    if constexpr (HasFields<T>) from.read(store);
    return from.ok() ? store.restored(entities) : nullptr;
  }
};

/// Stores of user component types, created on first use; a copy copies them all.
class UserStores {
 public:
  UserStores() = default;
  UserStores(const UserStores& other) { *this = other; }
  UserStores(UserStores&&) = default;
  UserStores& operator=(UserStores&&) = default;
  UserStores& operator=(const UserStores& other) {
    if (this == &other) return *this;
    std::vector<std::unique_ptr<AnyStore>> copies;
    for (const auto& s : other.stores_) copies.push_back(s->clone());
    stores_ = std::move(copies);
    return *this;
  }

  template <class T>
  Store<T>& of() {
    for (auto& s : stores_)
      if (s->type() == &kTypeName<T>) return static_cast<UserStore<T>&>(*s).store;
    stores_.push_back(std::make_unique<UserStore<T>>());
    return static_cast<UserStore<T>&>(*stores_.back()).store;
  }
  /// The store of a type, or null if it was never used.
  template <class T>
  const Store<T>* find() const {
    for (const auto& s : stores_)
      if (s->type() == &kTypeName<T>) return &static_cast<const UserStore<T>&>(*s).store;
    return nullptr;
  }
  void remove(std::span<const Entity> doomed) {
    for (auto& s : stores_) s->remove(doomed);
  }
  void add_to(Hash& hash, const EntityRule& rule) const {
    for (const auto& s : stores_) s->add_to(hash, rule);
  }
  /// In order of first use.
  std::span<const std::unique_ptr<AnyStore>> all() const { return stores_; }
  AnyStore* find(std::string_view name) {
    for (auto& s : stores_)
      if (s->name() == name) return s.get();
    return nullptr;
  }

 private:
  std::vector<std::unique_ptr<AnyStore>> stores_;
};

}  // namespace detail

}  // namespace pantin
