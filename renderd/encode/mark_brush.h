#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "renderd/engine/picture_source.h"

/// Draws the lines and texts of marks on a picture, like frontend/src/marks/paint.ts.
namespace diaphane::render {

/// A position in pixels of the whole picture, from its upper left corner.
struct PicturePoint {
  double x = 0, y = 0;
};

struct Disc {
  PicturePoint at;
  double radius = 0;
};

/// The shapes that make up one mark, except its text. A shape that the mark lacks is empty.
struct MarkLines {
  std::vector<std::array<PicturePoint, 2>> lines;
  std::optional<std::array<PicturePoint, 3>> head;  ///< filled
  std::optional<Disc> circle;                       ///< an outline
  std::vector<PicturePoint> dots;                   ///< dots whose radius is the pen's width
};

struct MarkColour {
  std::uint8_t r = 0, g = 0, b = 0;
};

struct Pen {
  MarkColour colour;
  double width = 1;
  double dash = 0;     ///< length of dashes and gaps; 0: solid lines
  double opacity = 1;  ///< opacity of the lines as a whole
};

/// The coverage of one text, 8 bits per pixel, whose upper left corner lies at `at`.
struct Stamp {
  std::uint32_t width = 0, height = 0;
  const std::uint8_t* coverage = nullptr;
  PicturePoint at;
  double scale = 1;  ///< pixels of the picture per pixel of the stamp
};

/// Draw on a picture, which may be a band of a larger one.
void draw(PictureRgb8& picture, const MarkLines& lines, const Pen& pen);
void draw(PictureRgb8& picture, const Stamp& stamp, MarkColour colour, double opacity);

}  // namespace diaphane::render
