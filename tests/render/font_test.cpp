#include "engine/render/font.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

using namespace pantin;
using namespace pantin::detail;

namespace {

int ink(const Font& font, char32_t letter) {
  const Glyph& g = font.glyph(letter);
  int sum = 0;
  for (int y = g.y; y < g.y + g.height; ++y)
    for (int x = g.x; x < g.x + g.width; ++x)
      sum += font.atlas[static_cast<std::size_t>(y) * font.atlas_width + x] > 127;
  return sum;
}

}  // namespace

TEST_CASE("letters are taken off UTF-8, and broken bytes give the replacement letter") {
  std::string_view text = "aé·⁻π\U0001F600";
  std::u32string letters;
  while (!text.empty()) letters += take_letter(text);
  CHECK(letters == U"aé·⁻π\U0001F600");
  for (std::string_view broken : {"\xff", "\xc3", "\xe2\x82", "\xc3(", "\x80", "\xc0\xaf"}) {
    CHECK(take_letter(broken) == char32_t(0xfffd));
  }
}

TEST_CASE("the usual fonts have Latin-1 and the signs of quantities") {
  const Font font = load_font(usual_fonts(), 18);
  if (font.source[0] != '/') {
    WARN("skipped, none of the usual fonts is on this machine");
    return;
  }
  const int unknown = ink(font, 0xfffd);
  CHECK(unknown > 0);
  for (char32_t letter : U"AgßÅ0·°±⁻¹πΔ≤") {
    if (letter == 0) continue;
    CHECK(font.glyphs.count(letter) == 1);
    CHECK(ink(font, letter) > 0);
  }
  CHECK(&font.glyph(U'\U0001F600') == &font.glyph(0xfffd));
  CHECK(font.width("111.") == Approx(font.width("888.")));  // numbers do not wobble
  CHECK(font.width("Größe") == Approx(font.width("Gr") + font.width("öße")));
}

TEST_CASE("without a font file the built-in letters are used and named") {
  constexpr const char* kMissing[] = {"/nowhere/Sans.ttf"};
  const Font font = load_font(kMissing, 18);
  if (font.source == "none") {
    WARN("skipped, built without stb_easy_font.h");
    return;
  }
  CHECK(font.source == "built-in (ASCII only)");
  for (char letter = '!'; letter <= '~'; ++letter) CHECK(ink(font, char32_t(letter)) > 0);
  CHECK(ink(font, U'i') < ink(font, U'W'));
  CHECK(font.width("abc") > font.width("ab"));
  CHECK(&font.glyph(U'ß') == &font.glyph(U'?'));
}

TEST_CASE("a file that is no font is passed over") {
  constexpr const char* kWrong[] = {"/etc/passwd"};
  CHECK(load_font(kWrong, 18).source != "/etc/passwd");
}
