import { create, fromBinary, toBinary, equals, fromJsonString, toJsonString } from "@bufbuild/protobuf";
import type { CameraPose } from "../input/camera";
import { length, subtract, vec3, type Vec3 } from "../input/vec3";
import { fullEffort, type Effort } from "../scene/effort";
import type { CurvedSlice } from "../slices/curve_view";
import type { Projection } from "../slices/oblique";
import { placeOf, type Oblique, type Plane, type Stack } from "../slices/stack";
import type { Coming, Cut, WantedSlice } from "../slices/store";
import {
  AckSchema,
  AnatomicalPlane,
  ClientMessageSchema,
  Codec,
  CurvedSliceSchema,
  DepthQuerySchema,
  EffortSchema,
  FreeCameraSchema,
  GuestSlicesSchema,
  HandoverSchema,
  HelloSchema,
  NeedKeySchema,
  ObliqueSliceSchema,
  Projection as ProjectionNumber,
  SceneUpdateSchema,
  ServerMessageSchema,
  SliceAccess,
  SliceRequestSchema,
  StillFormat,
  ViewportSchema,
  VisibilitySchema,
  type ClientMessage,
  type ExactSlice,
  type ServerMessage,
  type SliceStack,
} from "./gen/api/proto/stream_pb";
import {
  CameraSchema,
  Clip_PlaneSchema as ClipPlaneSchema,
  ClipSchema,
  SceneSchema,
  TransferFunctionSchema,
  Vec3Schema,
  type Scene,
} from "./gen/api/proto/scene_pb";

export { Codec, SliceAccess, StillFormat };
export type {
  Audience,
  Config,
  ExactSlice,
  Frame,
  Histogram,
  Look,
  Participant,
  Problem,
  State,
  Stats,
  Still,
  Treatment,
} from "./gen/api/proto/stream_pb";
export type { Preset, Scene } from "./gen/api/proto/scene_pb";
export { VolumeHeader_Modality as Modality, type VolumeHeader } from "./gen/api/proto/volume_pb";
export type { ServerMessage };

export const protocolVersion = 1;
export const subprotocol = "diaphane.v1";

/** The size of the picture in device pixels. */
export interface Viewport {
  readonly width: number;
  readonly height: number;
}

/** Scales a viewport to the limits of the protocol and keeps its shape. */
export function withinBounds(viewport: Viewport, most: number): Viewport {
  const shrink = Math.min(1, most / Math.max(viewport.width, viewport.height, 1));
  const side = (n: number) => Math.max(16, Math.round(n * shrink));
  return { width: side(viewport.width), height: side(viewport.height) };
}

type Bytes = Uint8Array<ArrayBuffer>;
const encoded = (message: ClientMessage): Bytes => toBinary(ClientMessageSchema, message);

/** Decodes a message of the server. @throws if the bytes are not a ServerMessage. */
export const decodeServerMessage = (bytes: Uint8Array): ServerMessage => fromBinary(ServerMessageSchema, bytes);

/** The formats that this browser can show. Each of them has been tested. */
export interface Abilities {
  readonly codecs: readonly Codec[];
  readonly stills: readonly StillFormat[];
}

export function encodeHello({ codecs, stills }: Abilities, pixelRatio: number, viewport: Viewport): Bytes {
  const value = create(HelloSchema, {
    protocol: protocolVersion,
    codecs: [...codecs],
    pixelRatio,
    viewport: create(ViewportSchema, viewport),
    stills: [...stills],
  });
  return encoded(create(ClientMessageSchema, { body: { case: "hello", value } }));
}

export interface SceneChange {
  readonly scene?: Scene;
  readonly viewport?: Viewport;
  /** Whether the gesture has ended. */
  readonly rest?: boolean;
  readonly effort?: Effort;
}

export function encodeScene(inputSeq: number, change: SceneChange): Bytes {
  const value = create(SceneUpdateSchema, { inputSeq: BigInt(inputSeq) });
  if (change.scene) value.scene = change.scene;
  if (change.viewport) value.viewport = create(ViewportSchema, change.viewport);
  value.rest = change.rest ?? false;
  const {
    smooth,
    stop_error: stopError,
    stop_samples: stopSamples,
    moving_scale: movingScale,
  } = change.effort ?? fullEffort;
  value.raw = !smooth;
  value.effort = create(EffortSchema, {
    stopError: stopError,
    stopSamples: BigInt(stopSamples),
    movingScale: movingScale,
  });
  return encoded(create(ClientMessageSchema, { body: { case: "scene", value } }));
}

/** Times in milliseconds of a monotonic clock. A time is absent if the frame did not get that far. */
export interface FrameTimes {
  readonly receivedMs: number;
  readonly decodedMs?: number;
  readonly presentedMs?: number;
}

export function encodeAck(seq: bigint, epoch: bigint, times: FrameTimes, queue: number): Bytes {
  const us = (ms: number | undefined) => BigInt(Math.round((ms ?? 0) * 1000));
  const value = create(AckSchema, {
    seq,
    epoch,
    receivedUs: us(times.receivedMs),
    decodedUs: us(times.decodedMs),
    presentedUs: us(times.presentedMs),
    queue,
  });
  return encoded(create(ClientMessageSchema, { body: { case: "ack", value } }));
}

export function encodeNeedKey(): Bytes {
  return encoded(create(ClientMessageSchema, { body: { case: "needKey", value: create(NeedKeySchema) } }));
}

/** Hands the role of the presenter to a participant. */
export function encodeHandover(to: string): Bytes {
  return encoded(create(ClientMessageSchema, { body: { case: "handover", value: create(HandoverSchema, { to }) } }));
}

export function encodeFreeCamera(on: boolean): Bytes {
  return encoded(
    create(ClientMessageSchema, { body: { case: "freeCamera", value: create(FreeCameraSchema, { on }) } }),
  );
}

/** Lets guests of this session see slices, or no longer. */
export function encodeGuestSlices(on: boolean): Bytes {
  return encoded(
    create(ClientMessageSchema, { body: { case: "guestSlices", value: create(GuestSlicesSchema, { on }) } }),
  );
}

export const planeNumbers: Readonly<Record<Plane, AnatomicalPlane>> = {
  axial: AnatomicalPlane.AXIAL,
  coronal: AnatomicalPlane.CORONAL,
  sagittal: AnatomicalPlane.SAGITTAL,
};
export const planeOf = (number: AnatomicalPlane): Plane | null =>
  (Object.entries(planeNumbers) as [Plane, AnatomicalPlane][]).find(([, one]) => one === number)?.[0] ?? null;

export const projectionNumbers: Readonly<Record<Projection, ProjectionNumber>> = {
  mean: ProjectionNumber.MEAN,
  maximum: ProjectionNumber.MAXIMUM,
  minimum: ProjectionNumber.MINIMUM,
};

export function encodeSlices(lacking: readonly WantedSlice[], taken: bigint): Bytes {
  const value = create(SliceRequestSchema, {
    taken,
    slices: lacking.map(({ plane, index, stack, curved }) => ({
      ...(plane === "curve" ? {} : { plane: planeNumbers[plane], index }),
      ...(stack?.oblique ? { oblique: obliqueOf(stack, stack.oblique, index) } : {}),
      ...(curved ? { curved: curvedOf(curved) } : {}),
    })),
  });
  return encoded(create(ClientMessageSchema, { body: { case: "slices", value } }));
}

const obliqueOf = (stack: Stack, { id, slab }: Oblique, slice: number) =>
  create(ObliqueSliceSchema, {
    id,
    columns: stack.columns,
    rows: stack.rows,
    first: create(Vec3Schema, placeOf(stack, { column: 0, row: 0, slice })),
    right: create(Vec3Schema, stack.right),
    down: create(Vec3Schema, stack.down),
    thickness: slab.mm,
    projection: projectionNumbers[slab.projection],
  });

const curvedOf = ({ id, points, angle, slab, pixel, grid }: CurvedSlice) =>
  create(CurvedSliceSchema, {
    id,
    columns: grid.columns,
    rows: grid.rows,
    points: points.map((point) => create(Vec3Schema, point)),
    pixel,
    angle,
    thickness: slab.mm,
    projection: projectionNumbers[slab.projection],
  });

/** Returns null if the slice belongs to a plane that this page does not know. */
export function comingSlice({ plane, data, second, labels, curved, ...rest }: ExactSlice): Coming | null {
  const { seq, index, columns, rows } = rest;
  const oblique = curved || rest.oblique;
  const known: Cut | null = curved ? "curve" : planeOf(plane);
  if (!known) return null;
  const coming = { seq, plane: known, index, columns, rows, data: data as Uint8Array<ArrayBuffer> };
  return {
    ...coming,
    ...(second.length > 0 ? { second: second as Uint8Array<ArrayBuffer> } : {}),
    ...(labels.length > 0 ? { labels: labels as Uint8Array<ArrayBuffer> } : {}),
    ...(oblique ? { oblique } : {}),
  };
}

/** Returns the complete stacks. Earlier versions of the server send none. */
export function stacksOf(stacks: readonly SliceStack[]): readonly Stack[] {
  return stacks.flatMap(({ plane, columns, rows, slices, first, right, down, next }) => {
    const known = planeOf(plane);
    if (!known || !columns || !rows || !slices || !first || !right || !down || !next) return [];
    return [
      {
        plane: known,
        columns,
        rows,
        slices,
        first: plain(first),
        right: plain(right),
        down: plain(down),
        next: plain(next),
      },
    ];
  });
}

/**
 * Encodes a query for the surface at a point. `x` and `y` range from 0 to 1, from the top left of
 * the picture.
 */
export function encodeDepthQuery(id: bigint, x: number, y: number): Bytes {
  return encoded(
    create(ClientMessageSchema, { body: { case: "depthQuery", value: create(DepthQuerySchema, { id, x, y }) } }),
  );
}

export function encodeVisibility(visible: boolean): Bytes {
  const value = create(VisibilitySchema, { visible });
  return encoded(create(ClientMessageSchema, { body: { case: "visibility", value } }));
}

export const plain = (v: { x: number; y: number; z: number } | undefined): Vec3 =>
  v ? vec3(v.x, v.y, v.z) : vec3(0, 0, 0);

/** Returns the camera of a scene, or null if it has none. */
export function cameraOf(scene: Scene): CameraPose | null {
  const camera = scene.camera;
  if (!camera?.eye || !camera.target) return null;
  return {
    eye: plain(camera.eye),
    target: plain(camera.target),
    up: plain(camera.up),
    verticalFovDegrees: camera.verticalFovDegrees,
  };
}

/** Returns a copy of the scene that is seen from another place through the same lens. */
export function withCamera(scene: Scene, pose: CameraPose): Scene {
  const before = cameraOf(scene);
  const lens = scene.camera ?? create(CameraSchema);
  // An orthographic camera also shows more from farther away, so that zooming works the same.
  const grown = before ? shownHeight(pose) / shownHeight(before) : 1;
  const camera = {
    ...lens,
    eye: create(Vec3Schema, pose.eye),
    target: create(Vec3Schema, pose.target),
    up: create(Vec3Schema, pose.up),
    verticalFovDegrees: pose.verticalFovDegrees,
    orthographicHeight: Number.isFinite(grown) && grown > 0 ? lens.orthographicHeight * grown : lens.orthographicHeight,
  };
  return { ...scene, camera };
}

const shownHeight = ({ eye, target, verticalFovDegrees }: CameraPose): number =>
  length(subtract(eye, target)) * Math.tan((verticalFovDegrees * Math.PI) / 360);

/** Returns the same scene, clipped to the part of the box that lies behind the planes. In mm. */
export function withClip(
  scene: Scene,
  box: { readonly low: readonly number[]; readonly high: readonly number[] },
  planes: readonly { readonly point: readonly number[]; readonly normal: readonly number[] }[],
): Scene {
  const vector = ([x = 0, y = 0, z = 0]: readonly number[]) => create(Vec3Schema, { x, y, z });
  const clip = create(ClipSchema, {
    boxLow: vector(box.low),
    boxHigh: vector(box.high),
    planes: planes.map((plane) =>
      create(ClipPlaneSchema, { point: vector(plane.point), normal: vector(plane.normal) }),
    ),
    cutsLight: true,
  });
  return { ...scene, clip };
}

/** Whether two scenes show the same materials. Their cameras may differ. */
export function sameLook(a: Scene, b: Scene): boolean {
  if (!a.transferFunction || !b.transferFunction) return a.transferFunction === b.transferFunction;
  return equals(TransferFunctionSchema, a.transferFunction, b.transferFunction);
}

/**
 * Whether two scenes have the same JSON text, which does not distinguish -0 from 0. A scene that
 * this tab stored is JSON.
 */
export const sameScene = (a: Scene, b: Scene): boolean => restored(a) === restored(b);

const restored = (scene: Scene): string => sceneToJson(sceneFromJson(sceneToJson(scene)) ?? scene);

/** Whether two scenes differ only in their cameras. */
export const sameButForCamera = (a: Scene, b: Scene): boolean =>
  equals(
    SceneSchema,
    create(SceneSchema, { ...a, camera: undefined }),
    create(SceneSchema, { ...b, camera: undefined }),
  );

export const cameraToJson = (scene: Scene): string =>
  scene.camera ? toJsonString(CameraSchema, scene.camera) : "null";

export const sceneToJson = (scene: Scene): string => toJsonString(SceneSchema, scene);

/** Parses a scene. Returns null if the text is damaged or of another version. */
export function sceneFromJson(json: string): Scene | null {
  try {
    return fromJsonString(SceneSchema, json);
  } catch {
    return null;
  }
}
