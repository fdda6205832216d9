#pragma once

#include <cstdint>
#include <optional>

#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

/// Draws a number into a picture's pixels, so that a bench can read from the viewer's screen which
/// input a picture answers, whatever codec and scaling lie between. The mark consists of 40 square
/// cells along the top edge. The n-th cell covers the columns [n width / 40, (n + 1) width / 40)
/// and is width / 40 rows high. The cells are white, black, the 24 low bits of `input_seq` with the
/// highest first and white for 1, an 8-bit checksum (the xor of those three bytes), and 6 black
/// cells. Leaves pictures narrower than 40 pixels unchanged.
void draw_frame_mark(PictureRgb8& picture, std::uint64_t input_seq);

/// Reads the number from the centres of the cells. Returns nullopt if there is no mark or the
/// checksum is wrong.
std::optional<std::uint32_t> read_frame_mark(const PictureRgb8& picture);

}  // namespace diaphane::render
