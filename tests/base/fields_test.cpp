// The list of fields of a struct: what follows from it.
#include "engine/base/fields.hpp"

#include <catch2/catch.hpp>

#include "engine/base/archive.hpp"
#include "tests/base/arity.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

enum class Mood : std::uint8_t { calm, cross };
constexpr Mood last_of(Mood) { return Mood::cross; }

struct Inner {
  Real weight = 1;
  Mood mood = Mood::calm;

  static void fields(auto& self, auto&& field) {
    field("weight", self.weight);
    field("mood", self.mood);
  }
};

struct Renamed {
  Real heft = 1;
  Mood mood = Mood::calm;

  static void fields(auto& self, auto&& field) {
    field("heft", self.heft);
    field("mood", self.mood);
  }
};

struct Held {
  Real state = 0, result = 0;
  std::vector<Inner> list;

  static void fields(auto& self, auto&& field) {
    field("state", self.state);
    field("result", passive(self.result));
    field("list", self.list);
  }
};

struct Shared {
  int number = 0;

  static void fields(auto& self, auto&& field) { field("number", self.number); }
};

struct Outer {
  bool yes = false;
  int count = 0;
  Vec3 point{0};
  Quat rotation{1, 0, 0, 0};
  Mat3 matrix{1};
  Pose pose;
  std::string word;
  Real row[3] = {0, 0, 0};
  std::array<Inner, 2> pair;
  std::vector<Inner> list;
  std::variant<Inner, Shared> either;
  std::optional<Inner> perhaps;
  std::unique_ptr<Inner> box;
  std::shared_ptr<const Shared> one, other;
  Real result = 0;
  Real cache = 0;

  static void fields(auto& self, auto&& field) {
    field("yes", self.yes);
    field("count", self.count);
    field("point", self.point);
    field("rotation", self.rotation);
    field("matrix", self.matrix);
    field("pose", self.pose);
    field("word", self.word);
    field("row", self.row);
    field("pair", self.pair);
    field("list", self.list);
    field("either", self.either);
    field("perhaps", self.perhaps);
    field("box", self.box);
    field("one", self.one);
    field("other", self.other);
    field("result", passive(self.result));
    field("cache", derived(self.cache));
  }
};

Outer full() {
  Outer o;
  o.yes = true, o.count = -7, o.point = {1, 2, 3}, o.rotation = Quat(0.5, 0.5, 0.5, 0.5);
  o.matrix[1][2] = 4, o.pose.position.y = 5, o.word = "word", o.row[2] = 6;
  o.pair[1].weight = 7, o.list = {{8, Mood::cross}, {9, Mood::calm}}, o.either = Shared{10};
  o.perhaps = Inner{11, Mood::cross}, o.box = std::make_unique<Inner>(Inner{12, Mood::cross});
  o.one = o.other = std::make_shared<Shared>(Shared{13});
  o.result = 14, o.cache = 15;
  return o;
}

std::uint64_t hash_of(const Outer& o) {
  Hash hash;
  hash_fields(hash, o);
  return hash.value();
}

std::string bytes_of(const Outer& o) {
  FieldWriter to;
  to.write(o);
  return to.take();
}

}  // namespace

TEST_CASE("the compiler counts the members of an aggregate, arrays as one") {
  static_assert(test::arity<Inner>() == 2);
  static_assert(test::arity<Outer>() == 17);
  CHECK(test::listed<Outer>() == 17);
}

TEST_CASE("what is written is read again, and what was shared is shared") {
  const Outer from = full();
  const std::string bytes = bytes_of(from);
  FieldReader reader(bytes);
  Outer to;
  reader.read(to);
  REQUIRE(reader.ok());
  CHECK(reader.left() == 0);
  CHECK(same_fields(from, to));
  CHECK(hash_of(from) == hash_of(to));
  CHECK(to.word == "word");
  CHECK(to.row[2] == 6);
  CHECK(std::get<Shared>(to.either).number == 10);
  CHECK(to.box->mood == Mood::cross);
  CHECK(to.one->number == 13);
  CHECK(to.one == to.other);
  CHECK(to.result == 14);
  CHECK(to.cache == 0);  // derived: not in the bytes
}

TEST_CASE("results and caches are not hashed, the rest is") {
  const std::uint64_t before = hash_of(full());
  Outer o = full();
  o.result = o.cache = 1;
  CHECK(hash_of(o) == before);
  o = full(), o.row[1] = 1e-300;
  CHECK(hash_of(o) != before);
  o = full(), o.list.pop_back();
  CHECK(hash_of(o) != before);
  o = full(), o.either = Inner{};
  CHECK(hash_of(o) != before);
  o = full(), o.box = nullptr;
  CHECK(hash_of(o) != before);
  o = full(), o.one = nullptr;
  CHECK(hash_of(o) != before);
}

TEST_CASE("the state alone is copied where results are to stay") {
  Held from{1, 2, {{3, Mood::cross}}}, to{4, 5, {}};
  copy_state(from, to);
  CHECK(to.state == 1);
  CHECK(to.result == 5);
  REQUIRE(to.list.size() == 1);
  CHECK(to.list[0].weight == 3);
}

TEST_CASE("bytes that were cut off or changed are refused or read as other values, never worse") {
  const std::string whole = bytes_of(full());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    FieldReader reader(std::string_view(whole).substr(0, size));
    Outer to;
    reader.read(to);
    CHECK_FALSE(reader.ok());
  }
  for (std::size_t i = 0; i < whole.size(); ++i)
    for (const char byte : {'\0', '\2', '\177', '\377'}) {
      std::string changed = whole;
      changed[i] = byte;
      FieldReader reader(changed);
      Outer to;
      reader.read(to);  // the sanitizers look on
      if (reader.ok()) CHECK(static_cast<int>(to.pair[0].mood) <= 1);
    }
}

TEST_CASE("a huge count in a short file takes no memory") {
  FieldWriter to;
  to.write(std::uint64_t(1) << 60);
  FieldReader reader(to.bytes());
  std::vector<Real> list;
  reader.read(list);
  CHECK(reader.fault() == " is cut off");
  CHECK(list.capacity() == 0);
}

TEST_CASE("the fingerprint of fields tells names, kinds and order apart") {
  CHECK(fields_fingerprint<Inner>() == fields_fingerprint<Inner>());
  CHECK(fields_fingerprint<Inner>() != fields_fingerprint<Renamed>());
  CHECK(fields_fingerprint<std::vector<Inner>>() != fields_fingerprint<Inner>());
}
