import { fewestSlices, mostFileBytes, mostPhases, mostVoxels } from "../judge";
import type { Phases, Suitable, Unsuitable } from "../types";
import { lengths, voxelBytes, type ImageHeader, type Triple } from "./header";

const refuse = (reason: Unsuitable["reason"], count = 0): Unsuitable => ({ suitable: false, reason, count });

/** Decides whether a file in a research format can be shown, as ingest does (ingest/build/nifti.h). */
export function judgeImage(image: ImageHeader): Suitable | Unsuitable {
  const { size } = image;
  if (!size.every((side) => Number.isInteger(side) && side >= 1)) return refuse("damaged");
  if (image.type === null || image.values !== 1 || image.coding === "other") return refuse("pixel_format");
  const spacing = image.axes ? lengths(image.axes) : image.spacing;
  if (!spacing.every((mm) => mm > 0 && Number.isFinite(mm))) return refuse("no_spacing");
  if (image.axes && !isOrthogonal(image.axes)) return refuse("bad_orientation");
  if (Math.min(...size) < fewestSlices) return refuse("too_few_slices", Math.min(...size));
  const { volumes, stepMs } = image;
  if (!Number.isInteger(volumes) || volumes < 1) return refuse("damaged");
  const voxels = size[0] * size[1] * size[2] * volumes;
  if (volumes > mostPhases || voxels > mostVoxels || Math.max(...size) > mostSide || voxelBytes(image) > mostFileBytes)
    return refuse("too_large");
  return {
    suitable: true,
    phases: volumes > 1 ? phasesOf(volumes, stepMs) : null,
    size,
    sizeMm: [size[0] * spacing[0], size[1] * spacing[1], size[2] * spacing[2]],
    leftOut: { scouts: 0, doubles: 0, damaged: 0, others: 0 },
    repairs: image.axes ? [] : [{ kind: "unknown_directions" }],
  };
}

const phasesOf = (count: number, stepMs: number | null): Phases => ({
  kind: stepMs === null ? "index" : "time",
  count,
  range: [0, (count - 1) * (stepMs ?? 1)],
});

/** Maximum of the signed 16-bit dimensions of NIfTI-1. */
const mostSide = 32767;

/** Whether the axes are orthogonal, with the same tolerance as in volume/header.cpp. */
function isOrthogonal([x, y, z]: readonly [Triple, Triple, Triple]): boolean {
  const cosine = (a: Triple, b: Triple) =>
    (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) / (Math.hypot(...a) * Math.hypot(...b));
  return [cosine(x, y), cosine(y, z), cosine(z, x)].every((one) => Math.abs(one) <= 1e-3);
}
