import { create, toBinary } from "@bufbuild/protobuf";
import { vec3, type Vec3 } from "../input/vec3";
import { measureKinds, type Measure, type MeasureKind } from "../slices/measure";
import type { Placing } from "../slices/placing";
import { projections, slabFrom, tiltFrom, type Tilt } from "../slices/oblique";
import type { PresentedSlices } from "../slices/presented";
import { planes, type Plane } from "../slices/stack";
import { plain, planeNumbers, planeOf, projectionNumbers } from "./messages";
import {
  AnatomicalPlane,
  ClientMessageSchema,
  GuestPointersSchema,
  Measurements_Kind as Kind,
  Measurements_MeasurementSchema as MeasurementSchema,
  MeasurementsSchema,
  PointerMove_InPictureSchema as InPictureSchema,
  PointerMove_InSliceSchema as InSliceSchema,
  PointerMoveSchema,
  SharedTakenSchema,
  SliceView_Layout as Layout,
  SliceView_PlacingSchema as PlacingSchema,
  SliceView_TiltSchema as TiltSchema,
  SliceViewSchema,
  type ClientMessage,
  type Measurements,
  type SharedState,
  type SliceView,
} from "./gen/api/proto/stream_pb";
import { Vec3Schema } from "./gen/api/proto/scene_pb";

export type { SharedState };

// What the participants of a live session show each other.

/** Where a pointer is: at a point of the picture (0 to 1 from the top left), or in a slice. */
export type PointerAt = { readonly x: number; readonly y: number } | { readonly plane: Plane; readonly place: Vec3 };

/** The pointer of another participant. Without a plane, it is on a surface in the picture. */
export interface Pointer {
  /** `Participant.number` of the owner. */
  readonly number: number;
  readonly plane: Plane | null;
  readonly place: Vec3;
}

type Bytes = Uint8Array<ArrayBuffer>;
const encoded = (body: ClientMessage["body"]): Bytes =>
  toBinary(ClientMessageSchema, create(ClientMessageSchema, { body }));
const vector = (place: Vec3) => create(Vec3Schema, place);

export function encodeSliceView(shown: PresentedSlices): Bytes {
  const window = { windowCentre: shown.window.centre, windowWidth: shown.window.width };
  if (shown.view === null) return encoded({ case: "sliceView", value: create(SliceViewSchema, window) });
  const value = create(SliceViewSchema, {
    ...layoutOf(shown.view),
    ...window,
    crosshair: vector(shown.crosshair),
    smooth: shown.smooth,
    overlay: shown.overlay,
    labels: shown.labels,
    slab: shown.slab.mm,
    projection: projectionNumbers[shown.slab.projection],
    tilts: tiltsOf(shown.tilt),
    placings: planes.flatMap((plane) => {
      const placing = shown.placings[plane];
      return placing ? [create(PlacingSchema, { ...placing, plane: planeNumbers[plane] })] : [];
    }),
  });
  return encoded({ case: "sliceView", value });
}

const tiltsOf = (tilt: Tilt | null) =>
  planes.flatMap((plane) =>
    tilt
      ? [
          create(TiltSchema, {
            plane: planeNumbers[plane],
            right: vector(tilt[plane].right),
            down: vector(tilt[plane].down),
          }),
        ]
      : [],
  );

function tiltOf({ tilts }: SliceView): Tilt | null {
  const tilt: Partial<Record<Plane, unknown>> = {};
  for (const { plane, right, down } of tilts) {
    const known = planeOf(plane);
    if (known) tilt[known] = { right: plain(right), down: plain(down) };
  }
  return tiltFrom(tilt);
}

function layoutOf(view: NonNullable<PresentedSlices["view"]>) {
  if (view === "four") return { layout: Layout.FOUR };
  if (view === "picture") return { layout: Layout.PICTURE };
  return { layout: Layout.SLICE, plane: planeNumbers[view] };
}

function viewOf({ layout, plane }: SliceView): PresentedSlices["view"] {
  switch (layout) {
    case Layout.FOUR:
      return "four";
    case Layout.PICTURE:
      return "picture";
    case Layout.SLICE:
      return planeOf(plane);
    default:
      return null;
  }
}

export function presentedOf(view: SliceView): PresentedSlices {
  const placings: Partial<Record<Plane, Placing>> = {};
  for (const { plane, zoom, column, row } of view.placings) {
    const known = planeOf(plane);
    if (known) placings[known] = { zoom, column, row };
  }
  return {
    view: viewOf(view),
    crosshair: plain(view.crosshair),
    window: { centre: view.windowCentre, width: view.windowWidth },
    smooth: view.smooth,
    overlay: view.overlay,
    labels: view.labels,
    tilt: tiltOf(view),
    slab: slabFrom({
      mm: view.slab,
      projection: projections.find((one) => projectionNumbers[one] === view.projection),
    }),
    placings,
  };
}

const kinds: Readonly<Record<MeasureKind, Kind>> = { ruler: Kind.RULER, angle: Kind.ANGLE, ellipse: Kind.ELLIPSE };

export function measurementsOf(measures: readonly Measure[]): Measurements {
  const items = measures.map(({ kind, plane, slice, points, corner }) =>
    create(MeasurementSchema, {
      kind: kinds[kind],
      slice,
      points: [...points, ...(corner ? [corner] : [])].map(vector),
      ...(plane === null ? {} : { plane: planeNumbers[plane] }),
    }),
  );
  return create(MeasurementsSchema, { items });
}

export const encodeMeasurements = (measures: readonly Measure[]): Bytes =>
  encoded({ case: "measurements", value: measurementsOf(measures) });

/** Converts measurements, except those of a kind or plane that this page does not know. */
export function measuresOf({ items }: Measurements): readonly Measure[] {
  return items.flatMap(({ kind, plane, slice, points }) => {
    const knownKind = measureKinds.find((one) => kinds[one] === kind);
    const knownPlane = planeOf(plane);
    if (!knownKind || (!knownPlane && plane !== AnatomicalPlane.ANATOMICAL_PLANE_UNSPECIFIED)) return [];
    const measure = { kind: knownKind, plane: knownPlane, slice, points: points.map((point) => plain(point)) };
    const [a, b, corner] = measure.points;
    return knownPlane === null && knownKind === "ellipse" && a && b && corner
      ? [{ ...measure, points: [a, b], corner }]
      : [measure];
  });
}

/** Encodes a move of this viewer's pointer. Null hides the pointer. */
export function encodePointer(at: PointerAt | null): Bytes {
  const value = create(PointerMoveSchema);
  if (at && "plane" in at) {
    const inSlice = create(InSliceSchema, { plane: planeNumbers[at.plane], place: vector(at.place) });
    value.at = { case: "slice", value: inSlice };
  } else if (at) {
    value.at = { case: "picture", value: create(InPictureSchema, at) };
  }
  return encoded({ case: "pointer", value });
}

export const pointersOf = ({ pointers }: SharedState): readonly (Pointer & { readonly shown: boolean })[] =>
  pointers.map(({ number, shown, plane, x, y, z }) => ({ number, shown, plane: planeOf(plane), place: vec3(x, y, z) }));

/** Lets guests point, or no longer. */
export const encodeGuestPointers = (on: boolean): Bytes =>
  encoded({ case: "guestPointers", value: create(GuestPointersSchema, { on }) });

export const encodeSharedTaken = (seq: bigint): Bytes =>
  encoded({ case: "sharedTaken", value: create(SharedTakenSchema, { seq }) });
