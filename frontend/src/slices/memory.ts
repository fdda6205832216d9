import { isNumber, isPoint, type Vec3 } from "../input/vec3";
import { clamp } from "../scene/numbers";
import { curveFrom, type RememberedCurve } from "./curve_view";
import { firstLabels, type LabelSetting } from "./label_overlay";
import { isWhole, measureKinds, type Measure, type MeasureKind } from "./measure";
import { slabFrom, tiltFrom, type Slab, type Tilt } from "./oblique";
import { planes, type Plane } from "./stack";
import type { Window } from "./window";

/** The colours of the look over the grey. `strength` is 0 to 1. */
export interface OverlaySetting {
  readonly shown: boolean;
  readonly strength: number;
}
export const firstOverlay: OverlaySetting = { shown: false, strength: 0.5 };

/** The state of the slice views of a volume that survives a reload. */
export interface RememberedSlices {
  /** The content hash of the volume, or its stacks as JSON. */
  readonly volume: string;
  readonly open: boolean;
  readonly crosshair: Vec3;
  readonly window: Window;
  readonly measures: readonly Measure[];
  readonly smooth: boolean;
  readonly overlay: OverlaySetting;
  readonly labels: LabelSetting;
  readonly tilt: Tilt | null;
  readonly slab: Slab;
  readonly curve: RememberedCurve;
}

/** Maximum number of measurements to remember. The newest are kept. */
export const mostRemembered = 200;

function isMeasure(value: unknown): value is Measure {
  const one = value as Partial<Record<keyof Measure, unknown>> | null;
  return (
    typeof one === "object" &&
    one !== null &&
    measureKinds.includes(one.kind as MeasureKind) &&
    (one.plane === null || planes.includes(one.plane as Plane)) &&
    (one.corner === undefined || isPoint(one.corner)) &&
    isNumber(one.slice) &&
    Array.isArray(one.points) &&
    one.points.every(isPoint) &&
    isWhole(one as Measure)
  );
}

function overlayFrom(value: unknown): OverlaySetting {
  const one = value as Partial<Record<keyof OverlaySetting, unknown>> | null | undefined;
  const strength = isNumber(one?.strength) ? clamp(one.strength, 0, 1) : firstOverlay.strength;
  return { shown: one?.shown === true, strength };
}

function labelsFrom(value: unknown): LabelSetting {
  const one = value as Partial<Record<keyof LabelSetting, unknown>> | null | undefined;
  const strength = isNumber(one?.strength) ? clamp(one.strength, 0, 1) : firstLabels.strength;
  return { shown: typeof one?.shown === "boolean" ? one.shown : null, strength };
}

export const slicesToText = (slices: RememberedSlices): string =>
  JSON.stringify({ ...slices, measures: slices.measures.filter(isWhole).slice(-mostRemembered) });

/** Parses the stored state. Returns null if the text is damaged or of another version. */
export function slicesFromText(text: string | null): RememberedSlices | null {
  try {
    const value = JSON.parse(text ?? "null") as Partial<Record<keyof RememberedSlices, unknown>> | null;
    if (value === null || typeof value.volume !== "string" || !isPoint(value.crosshair)) return null;
    const window = value.window as Partial<Record<keyof Window, unknown>> | undefined;
    if (!window || !isNumber(window.centre) || !isNumber(window.width)) return null;
    if (!Array.isArray(value.measures) || !value.measures.every(isMeasure)) return null;
    return {
      volume: value.volume,
      open: value.open === true,
      crosshair: value.crosshair,
      window: { centre: window.centre, width: window.width },
      measures: value.measures,
      smooth: value.smooth !== false,
      overlay: overlayFrom(value.overlay),
      labels: labelsFrom(value.labels),
      tilt: tiltFrom(value.tilt),
      slab: slabFrom(value.slab),
      curve: curveFrom(value.curve),
    };
  } catch {
    return null;
  }
}
