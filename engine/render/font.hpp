#pragma once
/// A glyph atlas, rendered once from a TrueType font, or from the font in stb_easy_font.h.
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace pantin::detail {

/// A glyph's rectangle in the atlas and its offset from the pen, in pixels; `top` is above the
/// baseline.
struct Glyph {
  int x = 0, y = 0, width = 0, height = 0;
  int left = 0, top = 0;
  float advance = 0;
};

struct Font {
  std::string source;  // file, or "built-in (ASCII only)"
  int atlas_width = 0, atlas_height = 0;
  std::vector<std::uint8_t> atlas;  // coverage, rows from the top
  std::unordered_map<char32_t, Glyph> glyphs;
  float ascent = 0, line_height = 0;  // pixels

  /// The glyph of a letter, or the font's replacement glyph.
  const Glyph& glyph(char32_t letter) const;
  float width(std::string_view utf8) const;
};

/// Usual paths of fonts.
std::span<const char* const> usual_fonts();

/// Loads the first of `files` that FreeType can read, at an em of `pixels`; otherwise the built-in
/// font.
Font load_font(std::span<const char* const> files, int pixels);

/// Decodes and removes the first letter of `utf8`; U+FFFD for an invalid byte.
char32_t take_letter(std::string_view& utf8);

}  // namespace pantin::detail
