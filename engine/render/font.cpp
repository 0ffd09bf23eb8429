#include "engine/render/font.hpp"

#include <ft2build.h>
#include FT_FREETYPE_H

#include <algorithm>
#include <array>
#include <memory>

namespace pantin::detail {

void draw_built_in(Font& font, int pixels);  // font_built_in.cpp

namespace {

constexpr int kAtlasWidth = 512;

/// Latin-1, and the symbols used in labels of quantities.
std::vector<char32_t> letters() {
  std::vector<char32_t> all;
  for (char32_t c = 0x20; c <= 0x7e; ++c) all.push_back(c);
  for (char32_t c = 0xa0; c <= 0xff; ++c) all.push_back(c);
  for (char32_t c = 0x391; c <= 0x3c9; ++c) all.push_back(c);  // Greek
  for (char32_t c :
       U"\u2013\u2014\u2018\u2019\u201c\u201d\u2022\u2026\u2032\u2033"
       U"\u2070\u2074\u2075\u2076\u2077\u2078\u2079\u207a\u207b\u2080\u2081\u2082"
       U"\u2190\u2191\u2192\u2193\u2202\u2206\u2211\u2212\u221a\u221e\u2248\u2260"
       U"\u2264\u2265\u25a0\u25b2\u25b6\u25cf\u2713\u2717\ufffd")
    if (c) all.push_back(c);
  return all;
}

struct FaceFree {
  void operator()(FT_Face face) const { FT_Done_Face(face); }
};
struct LibraryFree {
  void operator()(FT_Library library) const { FT_Done_FreeType(library); }
};
using Face = std::unique_ptr<FT_FaceRec_, FaceFree>;
using Library = std::unique_ptr<FT_LibraryRec_, LibraryFree>;

/// Packs glyphs into rows.
class Packer {
 public:
  explicit Packer(Font& font) : font_(font) { font_.atlas_width = kAtlasWidth; }

  void add(char32_t letter, Glyph glyph, const FT_Bitmap& bitmap) {
    if (x_ + glyph.width + 1 > kAtlasWidth) x_ = 1, y_ += row_ + 1, row_ = 0;
    row_ = std::max(row_, glyph.height);
    glyph.x = x_, glyph.y = y_;
    font_.atlas_height = y_ + row_ + 1;
    font_.atlas.resize(static_cast<std::size_t>(font_.atlas_height) * kAtlasWidth);
    for (int row = 0; row < glyph.height; ++row)
      std::copy_n(bitmap.buffer + row * bitmap.pitch, glyph.width,
                  font_.atlas.begin() + (y_ + row) * kAtlasWidth + x_);
    x_ += glyph.width + 1;
    font_.glyphs.emplace(letter, glyph);
  }

 private:
  Font& font_;
  int x_ = 1, y_ = 1, row_ = 0;
};

bool draw_face(Font& font, FT_Library library, const char* file, int pixels) {
  FT_Face raw = nullptr;
  if (FT_New_Face(library, file, 0, &raw) != 0) return false;
  const Face face(raw);
  if (FT_Set_Pixel_Sizes(raw, 0, static_cast<FT_UInt>(pixels)) != 0) return false;
  Packer packer(font);
  for (char32_t letter : letters()) {
    const FT_UInt index = FT_Get_Char_Index(raw, letter);
    if (index == 0) continue;
    if (FT_Load_Glyph(raw, index, FT_LOAD_RENDER | FT_LOAD_TARGET_LIGHT) != 0) continue;
    const FT_GlyphSlot slot = raw->glyph;
    if (slot->bitmap.width != 0 && slot->bitmap.pixel_mode != FT_PIXEL_MODE_GRAY) return false;
    Glyph glyph;
    glyph.width = static_cast<int>(slot->bitmap.width);
    glyph.height = static_cast<int>(slot->bitmap.rows);
    glyph.left = slot->bitmap_left, glyph.top = slot->bitmap_top;
    glyph.advance = static_cast<float>(slot->advance.x) / 64;
    packer.add(letter, glyph, slot->bitmap);
  }
  if (!font.glyphs.contains(U'?')) return false;
  font.ascent = static_cast<float>(raw->size->metrics.ascender) / 64;
  font.line_height = static_cast<float>(raw->size->metrics.height) / 64;
  font.source = file;
  return true;
}

}  // namespace

const Glyph& Font::glyph(char32_t letter) const {
  for (char32_t wanted : {letter, char32_t(0xfffd), U'?'})
    if (auto found = glyphs.find(wanted); found != glyphs.end()) return found->second;
  static const Glyph nothing;
  return nothing;
}

float Font::width(std::string_view utf8) const {
  float sum = 0;
  while (!utf8.empty()) sum += glyph(take_letter(utf8)).advance;
  return sum;
}

std::span<const char* const> usual_fonts() {
  static constexpr std::array kFiles = {
      "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
      "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
      "/usr/share/fonts/dejavu/DejaVuSans.ttf",
      "/usr/share/fonts/TTF/DejaVuSans.ttf",
      "/usr/share/fonts/truetype/dejavu/DejaVuSansMono.ttf",
      "/usr/share/fonts/dejavu-sans-mono-fonts/DejaVuSansMono.ttf",
      "/usr/share/fonts/TTF/DejaVuSansMono.ttf",
      "/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf",
      "/usr/share/fonts/truetype/noto/NotoSans-Regular.ttf",
  };
  return kFiles;
}

Font load_font(std::span<const char* const> files, int pixels) {
  FT_Library raw = nullptr;
  if (FT_Init_FreeType(&raw) == 0) {
    const Library library(raw);
    for (const char* file : files) {
      Font font;
      if (draw_face(font, raw, file, pixels)) return font;
    }
  }
  Font font;
  draw_built_in(font, pixels);
  return font;
}

char32_t take_letter(std::string_view& utf8) {
  const auto lead = static_cast<unsigned char>(utf8.front());
  utf8.remove_prefix(1);
  if (lead < 0x80) return lead;
  const std::size_t more = lead >= 0xf0 ? 3 : lead >= 0xe0 ? 2 : lead >= 0xc2 ? 1 : 0;
  if (more == 0 || lead > 0xf4 || utf8.size() < more) return 0xfffd;
  char32_t letter = lead & (0x3fu >> more);
  for (std::size_t i = 0; i < more; ++i) {
    const auto next = static_cast<unsigned char>(utf8[i]);
    if ((next & 0xc0) != 0x80) return 0xfffd;
    letter = letter << 6 | (next & 0x3fu);
  }
  utf8.remove_prefix(more);
  return letter;
}

}  // namespace pantin::detail
