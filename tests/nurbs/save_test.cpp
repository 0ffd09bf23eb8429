// Surfaces and curves to bytes and back.
#include <catch2/catch.hpp>
#include <memory>

#include "engine/base/archive.hpp"
#include "engine/nurbs/closest.hpp"
#include "engine/nurbs/makers.hpp"
#include "engine/nurbs/skin.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::detail::nurbs;

namespace {

/// What several may share.
struct Holder {
  std::shared_ptr<const Skin> skin;
  std::shared_ptr<const Wire> wire;

  static void fields(auto& self, auto&& field) {
    field("skin", self.skin);
    field("wire", self.wire);
  }
};

Holder read_again(const Holder& holder, std::string& fault) {
  FieldWriter out;
  out.write(holder);
  FieldReader in(out.bytes());
  Holder back;
  in.read(back);
  fault = in.fault();
  CHECK((!in.ok() || in.left() == 0));
  return back;
}

std::uint64_t hash_of(const Holder& holder) {
  Hash hash;
  hash_fields(hash, holder);
  return hash.value();
}

}  // namespace

TEST_CASE("nurbs: skins and curves come back from bytes as they were") {
  const Skin skins[] = {Skin({torus({}, 0.4, 0.1)}, 1e-9), Skin::ellipsoid({0.3, 0.2, 0.1}),
                        Skin({plane({}, 1, 2), plane({.origin = {1, 0, 0}}, 1, 2)}, 1e-9)};
  for (const Skin& skin : skins) {
    const Holder holder{std::make_shared<const Skin>(skin),
                        std::make_shared<const Wire>(ellipse({}, 0.3, 0.2))};
    std::string fault;
    const Holder back = read_again(holder, fault);
    REQUIRE(fault.empty());
    REQUIRE(back.skin->faces().size() == skin.faces().size());
    CHECK(back.skin->size() == skin.size());
    CHECK(hash_of(back) == hash_of(holder));
    for (std::size_t i = 0; i < skin.faces().size(); ++i) {
      const Face &one = skin.faces()[i], &two = back.skin->faces()[i];
      const Real u = one.u().domain().middle(), v = one.v().low() + 0.3 * one.v().domain().width();
      CHECK(one.at(u, v).s == two.at(u, v).s);
      CHECK(one.at(u, v).vv == two.at(u, v).vv);
      for (const Edge e : {Edge::u_low, Edge::u_high, Edge::v_low, Edge::v_high})
        CHECK(skin.neighbour(static_cast<int>(i), e) ==
              back.skin->neighbour(static_cast<int>(i), e));
    }
    const Vec3 p(0.5, 0.4, 0.3);
    CHECK(closest_point(*holder.wire, p).u == closest_point(*back.wire, p).u);
  }
}

TEST_CASE("nurbs: skins that differ in one number have different hashes") {
  Surface surface = torus({}, 0.4, 0.1);
  const Holder one{std::make_shared<const Skin>(std::vector{surface}, 1e-9), nullptr};
  surface.points[3].w *= 1 + 1e-15;
  const Holder two{std::make_shared<const Skin>(std::vector{surface}, 1e-9), nullptr};
  CHECK(hash_of(one) != hash_of(two));
  const Holder round{std::make_shared<const Skin>(Skin::ellipsoid({1, 1, 1})), nullptr};
  const Holder flat{std::make_shared<const Skin>(Skin::ellipsoid({1, 1, 0.5})), nullptr};
  CHECK(hash_of(round) != hash_of(flat));
}

TEST_CASE("nurbs: bytes that are no surface are refused, not evaluated") {
  Surface surface = torus({}, 0.4, 0.1);
  FieldWriter out;
  out.write(Holder{std::make_shared<const Skin>(std::vector{surface}, 1e-9), nullptr});
  int refused = 0;
  for (std::size_t at = 0; at < out.bytes().size(); at += 7) {
    std::string bytes = out.bytes();
    bytes[at] = static_cast<char>(bytes[at] ^ 0xff);
    FieldReader in(bytes);
    Holder back;
    in.read(back);
    if (!in.ok())
      ++refused;
    else if (back.skin)
      CHECK(errors_of(back.skin->face(0).surface(), "s").empty());
  }
  CHECK(refused > 20);
  surface.u.values[4] = -1;
  FieldWriter bad;
  bad.write(std::uint64_t{1}), bad.write(std::vector{surface}), bad.write(1e-9), bad.write(false);
  bad.write(std::uint64_t{0});
  FieldReader in(bad.bytes());
  Holder back;
  in.read(back);
  CHECK(in.fault().find("is a surface that cannot be evaluated") != std::string::npos);
}
