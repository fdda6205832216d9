import type { Channel, TransferFunction } from "../protocol/gen/api/proto/scene_pb";
import { screenValue } from "../scene/colour";

/**
 * The colours of a look by the bits of a 16-bit value: red, green and blue as on the screen, and how visible the value
 * is, from 0 to 255.
 */
export type LookColours = Uint8ClampedArray;

const lowest = -32768;
const highest = 32767;

/** Calls `visit` with each voxel value that a channel shows, and its opacity. */
function eachOpacity({ opacity }: Channel, visit: (bits: number, opacity: number) => void): void {
  opacity.forEach((point, i) => {
    const next = opacity[i + 1];
    const end = next ? Math.ceil(next.value) - 1 : point.value; // the next point belongs to the next pair
    for (let value = Math.max(lowest, Math.ceil(point.value)); value <= Math.min(highest, end); ++value) {
      const part = next ? (value - point.value) / (next.value - point.value) : 0;
      visit(value & 0xffff, point.opacity + part * ((next?.opacity ?? 0) - point.opacity));
    }
  });
}

/**
 * Returns the colours of a transfer function. Where materials overlap, they mix by their opacity, as in the picture.
 * How visible a value is depends on the greatest opacity of its own material, so that skin like glass is coloured as
 * well as bone.
 */
export function lookColours(transfer: TransferFunction): LookColours {
  const sums = new Float32Array(4 * 65536);
  const visible = new Float32Array(65536);
  for (const channel of transfer.channels) {
    const most = Math.max(0, ...channel.opacity.map(({ opacity }) => opacity));
    const { diffuse } = channel;
    if (channel.disabled || most === 0) continue;
    eachOpacity(channel, (bits, opacity) => {
      [diffuse?.r ?? 0, diffuse?.g ?? 0, diffuse?.b ?? 0, 1].forEach((part, i) => {
        sums[4 * bits + i] = (sums[4 * bits + i] ?? 0) + opacity * part;
      });
      visible[bits] = Math.max(visible[bits] ?? 0, opacity / most);
    });
  }
  const colours = new Uint8ClampedArray(4 * 65536);
  for (let bits = 0; bits < 65536; ++bits) {
    const sum = sums[4 * bits + 3] ?? 0;
    if (sum === 0) continue;
    for (let i = 0; i < 3; ++i) colours[4 * bits + i] = 255 * screenValue((sums[4 * bits + i] ?? 0) / sum);
    colours[4 * bits + 3] = 255 * (visible[bits] ?? 0);
  }
  return colours;
}
