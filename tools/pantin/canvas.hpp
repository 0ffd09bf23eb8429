#pragma once
// Two-dimensional drawings, as SVG or PNG.
#include <memory>
#include <string>
#include <string_view>

namespace pantin::program {

struct Ink {
  int red = 0, green = 0, blue = 0;  // 0..255, sRGB
};
enum class Anchor { start, middle, end };

/// Pixels from the top left corner.
struct Spot {
  double x = 0, y = 0;
};

class Canvas {
 public:
  static constexpr int kLetter = 13;  // height of the letters

  virtual ~Canvas() = default;
  virtual void box(Spot corner, Spot size, Ink ink) = 0;
  virtual void line(Spot from, Spot to, double width, Ink ink) = 0;
  /// `at` is on the baseline.
  virtual void text(Spot at, std::string_view utf8, Ink ink, Anchor anchor) = 0;
  /// The bytes of the file.
  virtual std::string bytes() = 0;

  void label(Spot at, std::string_view utf8) { text(at, utf8, {}, Anchor::start); }
};

/// Chooses by the ending of the path, .svg or .png; null for a PNG if this build cannot draw.
std::unique_ptr<Canvas> make_canvas(const std::string& path, int width, int height);

/// The colour of the k-th item; distinguishable with most forms of colour blindness.
Ink ink_of(std::size_t k);

/// The frame of a chart: ticks with numbers, names of the axes.
struct Axis {
  double low = 0, high = 1;
  std::string name;
};
struct Frame {
  Spot corner, size;  // of the inner area
  Axis across, up;

  Spot at(double x, double y) const;
  bool holds(double x, double y) const;
  /// Draws title and axes, over the content.
  void draw(Canvas& canvas, std::string_view title) const;
};

}  // namespace pantin::program
