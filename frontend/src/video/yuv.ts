/**
 * Converts 4:2:0 planes of studio range to RGBA by BT.601, which MPEG-1 implies. Each chroma sample applies to the four
 * pixels around it, as in jsmpeg's own renderers.
 *
 * @param stride of the luma plane in bytes. That of the chroma planes is half of it.
 */
export function yuvToRgba(
  y: Uint8ClampedArray,
  cr: Uint8ClampedArray,
  cb: Uint8ClampedArray,
  stride: number,
  width: number,
  height: number,
  rgba: Uint8ClampedArray,
): void {
  const half = stride >> 1;
  for (let row = 0; row < height; row++) {
    let luma = row * stride;
    let colour = (row >> 1) * half;
    let out = 4 * row * width;
    for (let column = 0; column < width; column += 2) {
      const blue = (cb[colour] ?? 0) - 128;
      const red = (cr[colour] ?? 0) - 128;
      colour += 1;
      // 16.16 fixed point: 255 / 219 and the matrix of BT.601, plus half a level for rounding.
      const toRed = 104597 * red + 32768;
      const toGreen = -25675 * blue - 53279 * red + 32768;
      const toBlue = 132201 * blue + 32768;
      const last = Math.min(2, width - column);
      for (let n = 0; n < last; n++) {
        const light = 76309 * ((y[luma] ?? 0) - 16);
        luma += 1;
        rgba[out] = (light + toRed) >> 16;
        rgba[out + 1] = (light + toGreen) >> 16;
        rgba[out + 2] = (light + toBlue) >> 16;
        rgba[out + 3] = 255;
        out += 4;
      }
    }
  }
}
