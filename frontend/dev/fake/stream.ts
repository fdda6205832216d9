import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import type { WebSocket } from "ws";
import { OverlayLookSchema, SceneSchema, type Scene } from "../../src/protocol/gen/api/proto/scene_pb";
import {
  AudienceSchema,
  ClientMessageSchema,
  Codec,
  FrameQuality,
  HistogramSchema,
  ServerMessageSchema,
  SliceAccess,
  type ServerMessage,
} from "../../src/protocol/gen/api/proto/stream_pb";
import {
  VolumeHeader_Modality as VolumeHeaderModality,
  VolumePhase_Kind as PhaseKind,
  VolumeHeaderSchema,
} from "../../src/protocol/gen/api/proto/volume_pb";
import { draw } from "./picture";

const colours: Record<string, [number, number, number]> = {
  skin: [0.95, 0.72, 0.6],
  muscle: [0.8, 0.3, 0.26],
  vessels: [0.85, 0.25, 0.2],
  bone: [0.95, 0.92, 0.84],
  airways: [0.62, 0.86, 0.95],
  brain: [0.86, 0.6, 0.52],
};

export const sceneNamed = (name: string): Scene => {
  const [r, g, b] = colours[name] ?? [1, 1, 1];
  return create(SceneSchema, {
    transferFunction: {
      extinctionPerMm: 1,
      channels: [
        {
          name,
          diffuse: { r, g, b },
          opacity: [
            { value: 0, opacity: 0 },
            { value: 300, opacity: 1 },
          ],
        },
      ],
    },
    lights: [
      {
        name: "key",
        cameraLocked: true,
        shape: {
          case: "rectangle",
          value: {
            corner: { x: -300, y: 240, z: 260 },
            u: { x: 150, y: 0, z: 80 },
            v: { x: 0, y: 130, z: -60 },
            radiance: { r: 40, g: 38.8, b: 36.8 },
          },
        },
      },
      {
        name: "fill",
        cameraLocked: true,
        shape: {
          case: "rectangle",
          value: {
            corner: { x: 300, y: -100, z: 300 },
            u: { x: 100, y: 0, z: -150 },
            v: { x: 0, y: 200, z: 0 },
            radiance: { r: 9, g: 9.6, b: 10 },
          },
        },
      },
      { name: "sky", shape: { case: "environment", value: { radiance: { r: 0.26, g: 0.27, b: 0.29 } } } },
    ],
    camera: {
      eye: { x: 0, y: -520, z: 30 },
      target: { x: 0, y: 0, z: 0 },
      up: { x: 0, y: 0, z: 1 },
      verticalFovDegrees: 30,
    },
  });
};

const volume = create(VolumeHeaderSchema, {
  format: 1,
  size: [200, 240, 180],
  spacing: [0.9, 0.9, 1],
  direction: [1, 0, 0, 0, 1, 0, 0, 0, 1],
  modality: VolumeHeaderModality.CT,
  windowCenter: 40,
  windowWidth: 400,
  minimum: -1024,
  maximum: 3071,
});
/** A heartbeat in as many phases as a scan has. */
export const phasesOf = (count: number) =>
  Array.from({ length: count }, (_, phase) => ({
    $typeName: "diaphane.v1.VolumePhase" as const,
    kind: PhaseKind.CYCLE,
    value: (100 * phase) / count,
  }));
/** Air, soft tissue and bone. */
const hill = (value: number, at: number, width: number, height: number) =>
  height * Math.exp(-(((value - at) / width) ** 2));
const histogram = create(HistogramSchema, {
  minimum: -1024,
  width: 16,
  counts: Array.from({ length: 256 }, (_, i) => -1024 + 16 * i).map((v) =>
    Math.round(
      hill(v, -1000, 30, 2e6) +
        hill(v, -90, 40, 9e4) +
        hill(v, 45, 35, 4e5) +
        4000 * Math.exp(-Math.abs(v - 300) / 400),
    ),
  ),
});

/** The owner, alone, who may use the slices and save videos. */
const audience = create(AudienceSchema, {
  you: "anna",
  participants: [{ id: "anna", owner: true, presenter: true }],
  presenter: "anna",
  slices: SliceAccess.WHOLE,
  downloads: true,
});
/** Samples per pixel of a finished picture, and by which factor they grow. Few pictures, as each takes time to draw. */
const finished = 64;
const growth = 8;

export interface FakeSession {
  scene: Scene;
  inputSeq: bigint;
  /** Grows across connections, as a renderer's does. */
  epoch: bigint;
  /** Number of phases of the scan. */
  phases?: number;
  /** Whether a second scan is shown over the scan. */
  fused?: boolean;
}

const overlayLooks = ["hot", "bone"].map((name) =>
  create(OverlayLookSchema, {
    name,
    overlay: {
      share: 0.5,
      ...(sceneNamed(name).transferFunction ? { transferFunction: sceneNamed(name).transferFunction } : {}),
    },
  }),
);

export function serveStream(socket: WebSocket, session: FakeSession): void {
  let size = { width: 640, height: 480 };
  let seq = 0n;
  let samples = 0;
  let begun = Date.now();
  const say = (body: ServerMessage["body"]) =>
    socket.send(toBinary(ServerMessageSchema, create(ServerMessageSchema, { body })));
  const restart = () => {
    session.epoch += 1n;
    samples = 0;
    begun = Date.now();
  };
  const tick = setInterval(() => {
    if (seq === 0n && samples < 0) return;
    const next = samples === 0 ? 1 : samples * growth;
    if (next > finished || socket.bufferedAmount > 0) return;
    if (Date.now() - begun < next * 12 && next > 1) return;
    samples = next;
    const moving = samples <= 2 ? 2 : 1;
    const [width, height] = [Math.round(size.width / moving), Math.round(size.height / moving)];
    const data = draw(
      session.scene,
      Math.min(width, 900),
      Math.min(height, Math.round((900 * height) / width)),
      samples,
      session.phases ? session.scene.volumePhase / session.phases : 0,
    );
    say({
      case: "frame",
      value: {
        $typeName: "diaphane.v1.Frame",
        codec: Codec.JPEG,
        key: true,
        epoch: session.epoch,
        seq: ++seq,
        inputSeq: session.inputSeq,
        iteration: BigInt(samples),
        error: samples < 2 ? Infinity : 0.35 / Math.sqrt(samples),
        width,
        height,
        renderUs: BigInt((Date.now() - begun) * 1000 + 4000),
        encodeUs: 900n,
        denoised: samples <= 4,
        stops: 0,
        volumePhase: session.scene.volumePhase,
        decoder: "",
        quality: moving === 1 ? FrameQuality.SETTLED : FrameQuality.MOVING,
        data,
      },
    });
    say({
      case: "stats",
      value: {
        $typeName: "diaphane.v1.Stats",
        samplesPerSecond: 61.3,
        sessions: 1,
        droppedSamples: 0n,
        framesSkipped: 0n,
      },
    });
    if (samples >= finished)
      say({
        case: "state",
        value: {
          $typeName: "diaphane.v1.State",
          epoch: session.epoch,
          converged: true,
          lossless: false,
          biased: false,
        },
      });
  }, 30);
  samples = -1;
  socket.on("close", () => clearInterval(tick));
  socket.on("message", (raw) => {
    const { body } = fromBinary(ClientMessageSchema, new Uint8Array(raw as Buffer));
    if (body.case === "hello") {
      size = body.value.viewport ?? size;
      say({
        case: "config",
        value: {
          $typeName: "diaphane.v1.Config",
          protocol: 1,
          sessionId: "s",
          codec: Codec.JPEG,
          engine: "cpu",
          device: "2 CPU threads",
          scene: session.scene,
          inputSeq: session.inputSeq,
          follower: false,
          volume: { ...volume, phases: phasesOf(session.phases ?? 0) },
          histogram,
          sliceStacks: [],
          ...(session.fused
            ? { second: { $typeName: "diaphane.v1.SecondVolume" as const, volume, histogram, looks: overlayLooks } }
            : {}),
          presets: Object.keys(colours).map((name) => ({
            $typeName: "diaphane.v1.Preset" as const,
            name,
            scene: sceneNamed(name),
          })),
        },
      });
      say({ case: "audience", value: audience });
      const loaded = session.phases ?? 0;
      if (loaded > 0)
        say({ case: "volumePhases", value: { $typeName: "diaphane.v1.VolumePhases", loaded, fit: true } });
      restart();
    } else if (body.case === "scene") {
      session.inputSeq = body.value.inputSeq;
      if (body.value.scene) session.scene = body.value.scene;
      if (body.value.viewport) size = body.value.viewport;
      restart();
    }
  });
}
