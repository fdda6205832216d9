#pragma once

#include <cstdint>
#include <optional>

#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

/// Draws a number into a picture's pixels, so that a bench can read on the viewer's screen which
/// input a picture answers, whatever codec and scaling lie between: 40 square cells along the top
/// edge, the n-th over the columns [n width / 40, (n + 1) width / 40), width / 40 rows high. White,
/// black; the 24 low bits of `input_seq`, the highest first, white for 1; 8 bits of checksum, the
/// xor of those three bytes; 6 black. A picture narrower than 40 pixels stays as it is.
void draw_frame_mark(PictureRgb8& picture, std::uint64_t input_seq);

/// The number in the pixels, from the middles of the cells; nothing where there is no mark or the
/// checksum does not fit.
std::optional<std::uint32_t> read_frame_mark(const PictureRgb8& picture);

}  // namespace diaphane::render
