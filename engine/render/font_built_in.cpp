// The coarse glyphs of stb_easy_font, for machines without fonts.
#include <algorithm>

#include "engine/base/compiler.hpp"
#include "engine/render/font.hpp"

#if __has_include(<stb/stb_easy_font.h>)
PANTIN_QUIET_BEGIN
#include <stb/stb_easy_font.h>
PANTIN_QUIET_END
#define PANTIN_HAS_EASY_FONT
#endif

namespace pantin::detail {

void draw_built_in(Font& font, int pixels) {
  font.source = "none";
#ifdef PANTIN_HAS_EASY_FONT
  // A glyph of stb_easy_font is at most 8 by 12 units; each gets a cell of its own.
  const int unit = std::max(1, (pixels + 4) / 10), cell_width = 10 * unit, cell_height = 13 * unit;
  font.source = "built-in (ASCII only)";
  font.atlas_width = 16 * cell_width;
  font.atlas_height = 6 * cell_height;
  font.atlas.assign(static_cast<std::size_t>(font.atlas_width) * font.atlas_height, 0);
  font.ascent = 9.f * static_cast<float>(unit);
  font.line_height = 13.f * static_cast<float>(unit);
  struct Corner {
    float x, y, z;
    unsigned char colour[4];
  };
  for (int letter = 0x20; letter <= 0x7e; ++letter) {
    char text[2] = {static_cast<char>(letter), 0};
    Corner corners[4 * 64];
    const int quads = stb_easy_font_print(0, 0, text, nullptr, corners, sizeof corners);
    Glyph glyph;
    glyph.x = (letter - 0x20) % 16 * cell_width, glyph.y = (letter - 0x20) / 16 * cell_height;
    glyph.width = cell_width, glyph.height = cell_height;
    glyph.top = 9 * unit;
    glyph.advance = static_cast<float>(stb_easy_font_width(text) * unit);
    font.glyphs.emplace(static_cast<char32_t>(letter), glyph);
    for (int q = 0; q < quads; ++q) {
      const Corner &low = corners[4 * q], &high = corners[4 * q + 2];
      for (int y = static_cast<int>(low.y) * unit; y < static_cast<int>(high.y) * unit; ++y)
        for (int x = static_cast<int>(low.x) * unit; x < static_cast<int>(high.x) * unit; ++x)
          if (x < cell_width && y < cell_height)
            font.atlas[static_cast<std::size_t>((glyph.y + y) * font.atlas_width + glyph.x + x)] =
                255;
    }
  }
#else
  static_cast<void>(pixels);
#endif
}

}  // namespace pantin::detail
